#ifndef INSONIFY_EXAMPLES_LIVE_VIEWER_WORKER_HPP
#define INSONIFY_EXAMPLES_LIVE_VIEWER_WORKER_HPP

#include "../appearance.hpp"
#include "../loop.hpp"
#include <condition_variable>
#include <exception>
#include <memory>
#include <mutex>
#include <thread>

namespace live {

/// The anatomy that the window shows, at rest, from the opaque to the transparent.
struct shown_anatomy {
    struct part {
        mesh surface{}; ///< in the world
        vec3 colour{1};
        float opacity = 1;
        bool is_cut = false;
    };
    std::vector<part> parts{};
    mesh probe{}; ///< in its own coordinates
    aabb box{};

    explicit shown_anatomy(const session& of) : probe{make_probe_body(of.machine.probe)}, box{anatomy_box(of.body)} {
        const std::vector<float> opacity = opacities(of.body);
        for (std::size_t i = 0; i < opacity.size(); ++i) {
            const object& one = of.body.objects()[i];
            if (is_tool(one)) continue;
            parts.push_back({one.surface, colour_of(one), opacity[i], is_cut(one)});
            for (vec3& point : parts.back().surface.positions) point = one.at.point(point);
        }
        std::stable_sort(parts.begin(), parts.end(),
                         [](const part& a, const part& b) { return a.opacity > b.opacity; });
    }
};

/// What the window shows of a frame.
struct shown_frame {
    std::shared_ptr<const shown_anatomy> anatomy{};
    colour_image screen{};
    image strip{};
    strip_scale axes{}; ///< of the strip
    std::vector<legend_entry> legend{};
    std::vector<float> values{};             ///< of `controls()`, in their order
    std::vector<std::vector<float>> parts{}; ///< of those that have parts, in the same order
    std::vector<std::uint8_t> seen{};        ///< of each pixel of the screen: 255 in the picture, 0 beside a sector
    std::vector<vec3> outline{};             ///< see `field_of_view`
    vec3 corners[4] = {}; ///< of the picture in the world: upper left, upper right, lower right, lower left
    pose probe{}, needle{};
    vec2 needle_entry{0, 0}; ///< x, y in the world, metres
    std::uint32_t gauge = 22;
    float bevel = 15_deg;
    float depth = 0, top = 0, focus = 0; ///< metres: of the picture's lower and upper edge, and of the focus
    float pitch = 1;                     ///< of a pixel, metres
    mode shown = mode::b;
    float scale = 0;                       ///< of Doppler, m/s
    float contact = 1;                     ///< fraction of the lines that touch
    std::optional<measurement> measured{}; ///< in this picture
    bool frozen = false;
    double seconds = 0;                        ///< from frame to frame
    std::uint64_t count = 0;                   ///< frames so far
    std::uint64_t replayed = 0, to_replay = 0; ///< frames of a recorded session; 0: it is over
};

/// Runs a session in a thread of its own: the window never waits for a frame.
class worker {
  public:
    /// @param played  frames of a recorded session, which come first
    /// @param frames  after so many no more are drawn
    worker(session& of, std::optional<player> played, std::uint64_t frames)
        : session_{of}, replay_{std::move(played)}, frames_{frames}, thread_{[this] {
              run_loop(session_, replay_, 30, *this);
          }} {}
    worker(const worker&) = delete;
    worker& operator=(const worker&) = delete;
    ~worker() {
        {
            const std::lock_guard lock{mutex_};
            ends_ = true;
        }
        wake_.notify_one();
        thread_.join();
    }

    /// What a user does; nothing while a recorded session is played.
    void push(const event& one) {
        const std::lock_guard lock{mutex_};
        if (shown_.to_replay == 0) events_.push_back(one);
    }
    /// Ends the recorded session; the scanner goes on from there.
    void stop_replay() {
        const std::lock_guard lock{mutex_};
        stops_replay_ = true;
    }
    /// The last frame, if it is newer than the one that is given.
    bool newer(shown_frame& last) {
        const std::lock_guard lock{mutex_};
        if (shown_.count == last.count) return false;
        last = shown_;
        return true;
    }
    /// The last event that was refused, in words.
    std::string fault() {
        const std::lock_guard lock{mutex_};
        return fault_;
    }

    // For `run_loop`, in the thread.
    bool wait(steady::time_point until) {
        std::unique_lock lock{mutex_};
        if (shown_.count >= frames_) wake_.wait(lock, [&] { return ends_; });
        return !wake_.wait_until(lock, until, [&] { return ends_; });
    }
    bool take(session& with) {
        std::vector<event> now;
        {
            const std::lock_guard lock{mutex_};
            now.swap(events_);
        }
        for (const event& one : now) try {
                with.apply(one);
            } catch (const std::exception& refused) {
                refuse(refused);
            }
        return true;
    }
    bool stops_replay() {
        const std::lock_guard lock{mutex_};
        return stops_replay_;
    }
    void refuse(const std::exception& fault) {
        const std::lock_guard lock{mutex_};
        fault_ = fault.what();
    }
    void draw(session& with) try {
        with.frame(exec::par_unseq);
        const scanner<array_probe>& machine = with.machine;
        if (bodies_ != with.bodies) {
            anatomy_ = std::make_shared<const shown_anatomy>(with);
            bodies_ = with.bodies;
        }
        const uvec2 size = with.screen().size;
        const auto right = static_cast<float>(size.x), bottom = static_cast<float>(size.y);
        const double seconds = clock_.lap();
        const std::lock_guard lock{mutex_};
        shown_.anatomy = anatomy_;
        shown_.screen = with.screen();
        shown_.strip = with.strip();
        shown_.axes = with.strip_axes();
        shown_.legend = with.legend();
        shown_.values.clear();
        shown_.parts.resize(controls().size());
        for (std::size_t i = 0; i < controls().size(); ++i) {
            const control& one = controls()[i];
            shown_.values.push_back(one.value != nullptr ? one.value(with) : 0);
            shown_.parts[i].resize(one.parts);
            for (std::uint32_t part = 0; part < one.parts; ++part) shown_.parts[i][part] = one.part_value(with, part);
        }
        shown_.seen.resize(shown_.screen.pixels.size());
        for (std::size_t i = 0; i < shown_.seen.size(); ++i) shown_.seen[i] = is_seen(machine, i) ? 255 : 0;
        shown_.outline = field_of_view(machine);
        shown_.corners[0] = machine.point({0, 0});
        shown_.corners[1] = machine.point({right, 0});
        shown_.corners[2] = machine.point({right, bottom});
        shown_.corners[3] = machine.point({0, bottom});
        shown_.probe = machine.at();
        shown_.needle = with.needle.at();
        shown_.needle_entry = {with.needle.entry.x, with.needle.entry.y};
        shown_.gauge = with.needle.gauge;
        shown_.bevel = with.needle.bevel;
        shown_.top = machine.map().point({0, 0}).y;
        shown_.depth = machine.map().point({0, bottom}).y;
        shown_.pitch = (shown_.depth - shown_.top) / std::max(bottom, 1.0F);
        shown_.focus = machine.probe.focus > 0 ? machine.probe.focus : machine.settings.depth / 2;
        shown_.shown = with.shown;
        shown_.scale = with.doppler.scale;
        shown_.contact = static_cast<float>(with.touch().touching) / static_cast<float>(machine.probe.lines);
        shown_.measured = with.shows_measurement ? std::optional{with.measured.back()} : std::nullopt;
        shown_.frozen = machine.frozen();
        shown_.seconds = seconds;
        shown_.replayed = replay_ ? replay_->played() : 0;
        shown_.to_replay = replay_ ? replay_->frames() : 0;
        ++shown_.count;
    } catch (const std::exception& failed) {
        refuse(failed);
    }

  private:
    session& session_;
    std::optional<player> replay_; // of the thread
    std::uint64_t frames_;
    insonify::detail::stopwatch clock_{};            // of the thread
    std::shared_ptr<const shown_anatomy> anatomy_{}; // of the thread
    std::uint32_t bodies_ = 0;                       // of the session, when that was made
    std::mutex mutex_{};
    std::condition_variable wake_{};
    std::vector<event> events_{};
    shown_frame shown_{};
    std::string fault_{};
    bool ends_ = false, stops_replay_ = false;
    std::thread thread_;
};

} // namespace live

#endif
