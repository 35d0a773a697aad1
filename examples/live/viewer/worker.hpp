#ifndef INSONIFY_EXAMPLES_LIVE_VIEWER_WORKER_HPP
#define INSONIFY_EXAMPLES_LIVE_VIEWER_WORKER_HPP

#include "../session.hpp"
#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace live {

/// What the window shows of a frame.
struct shown_frame {
    colour_image screen{};
    image strip{};
    strip_scale axes{}; ///< of the strip
    std::vector<legend_entry> legend{};
    std::vector<float> values{}; ///< of `controls()`, in their order
    vec3 corners[4] = {};        ///< of the picture in the world: upper left, upper right, lower right, lower left
    pose probe{}, needle{};
    std::uint32_t gauge = 22;
    float bevel = 15_deg;
    float depth = 0, top = 0, focus = 0; ///< metres: of the picture's lower and upper edge, and of the focus
    float pitch = 1;                     ///< of a pixel, metres
    mode shown = mode::b;
    float scale = 0;    ///< of Doppler, m/s
    float contact = 1;  ///< fraction of the lines that touch
    float measured = 0; ///< the last distance, metres
    float area = 0;     ///< the last area, square metres
    bool frozen = false;
    double seconds = 0;      ///< from frame to frame
    std::uint32_t count = 0; ///< frames so far
};

/// Runs a session in a thread of its own: the window never waits for a frame.
class worker {
  public:
    /// @param steps  draws only at "frame" events, as in a recorded session
    worker(session& of, bool steps) : session_{of}, steps_{steps}, thread_{[this] { run(); }} {}
    ~worker() {
        {
            const std::lock_guard lock{mutex_};
            stops_ = true;
        }
        wake_.notify_one();
        thread_.join();
    }

    void push(const event& one) {
        {
            const std::lock_guard lock{mutex_};
            events_.push_back(one);
        }
        wake_.notify_one();
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

  private:
    void run() {
        for (;;) {
            std::vector<event> now;
            {
                std::unique_lock lock{mutex_};
                wake_.wait(lock, [&] { return stops_ || !steps_ || !events_.empty(); });
                if (stops_) return;
                now.swap(events_);
            }
            for (const event& one : now) try {
                    if (one.name == "frame")
                        draw();
                    else
                        session_.apply(one);
                } catch (const std::exception& refused) {
                    const std::lock_guard lock{mutex_};
                    fault_ = refused.what();
                }
            if (!steps_) try {
                    draw();
                } catch (const std::exception& failed) {
                    const std::lock_guard lock{mutex_};
                    fault_ = failed.what();
                }
        }
    }

    void draw() {
        session_.frame(exec::par_unseq);
        const scanner<linear_array>& machine = session_.machine;
        const uvec2 size = session_.screen().size;
        const auto right = static_cast<float>(size.x), bottom = static_cast<float>(size.y);
        const double seconds = clock_.lap();
        const std::lock_guard lock{mutex_};
        shown_.screen = session_.screen();
        shown_.strip = session_.strip();
        shown_.axes = session_.strip_axes();
        shown_.legend = session_.legend();
        shown_.values.clear();
        for (const control& one : controls()) shown_.values.push_back(one.value != nullptr ? one.value(session_) : 0);
        shown_.corners[0] = machine.point({0, 0});
        shown_.corners[1] = machine.point({right, 0});
        shown_.corners[2] = machine.point({right, bottom});
        shown_.corners[3] = machine.point({0, bottom});
        shown_.probe = machine.at();
        shown_.needle = session_.needle.at();
        shown_.gauge = session_.needle.gauge;
        shown_.bevel = session_.needle.bevel;
        shown_.top = machine.map().point({0, 0}).y;
        shown_.depth = machine.map().point({0, bottom}).y;
        shown_.pitch = (shown_.depth - shown_.top) / std::max(bottom, 1.0F);
        shown_.focus = machine.probe.focus > 0 ? machine.probe.focus : machine.settings.depth / 2;
        shown_.shown = session_.shown;
        shown_.scale = session_.doppler.scale;
        shown_.contact = static_cast<float>(session_.touch().touching) / static_cast<float>(machine.probe.lines);
        shown_.measured = session_.measured.empty() ? 0 : session_.measured.back();
        shown_.area = session_.areas.empty() ? 0 : session_.areas.back().area;
        shown_.frozen = machine.frozen();
        shown_.seconds = seconds;
        ++shown_.count;
    }

    session& session_;
    bool steps_;
    insonify::detail::stopwatch clock_{};
    std::mutex mutex_{};
    std::condition_variable wake_{};
    std::vector<event> events_{};
    shown_frame shown_{};
    std::string fault_{};
    bool stops_ = false;
    std::thread thread_;
};

} // namespace live

#endif
