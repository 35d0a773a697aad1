/// The loop of the live programs: a session's time is clock time at any rate, a recorded session is played at its own pace, and
/// both end at once. live_tests loop
#include "../loop.hpp"
#include <cstdio>
#include <thread>

namespace loop_test {
namespace {

using namespace insonify;

double seconds_since(live::steady::time_point begin) {
    return std::chrono::duration<double>(live::steady::now() - begin).count();
}

/// A program that ends after a time.
struct program {
    double ends_after = 2, picture_time = 0; ///< seconds
    bool looks = true;                       ///< somebody does
    std::uint32_t frames = 0, refused = 0;
    live::steady::time_point begin = live::steady::now();
    double drawn_at = 0; ///< the last picture

    bool wait(live::steady::time_point until) const {
        const auto end =
            begin + std::chrono::duration_cast<live::steady::duration>(std::chrono::duration<double>{ends_after});
        std::this_thread::sleep_until(std::min(until, end));
        return live::steady::now() < end;
    }
    bool take(live::session&) const { return looks; }
    static bool stops_replay() { return false; }
    void refuse(const std::exception&) { ++refused; }
    void draw(live::session& with) {
        drawn_at = seconds_since(begin);
        with.advance(exec::par_unseq);
        if (with.record != nullptr) with.record->add_frame();
        std::this_thread::sleep_for(std::chrono::duration<double>{picture_time});
        ++frames;
    }
};

bool check(bool holds, const char* text, double measured, double expected) {
    std::printf("%s %s: %.3f, expected %.3f\n", holds ? "ok  " : "FAIL", text, measured, expected);
    return holds;
}

// Heart beats of the session in those of the clock.
bool time_passes(double rate, double picture_time) {
    live::session one;
    std::optional<live::player> none;
    program running{.picture_time = picture_time};
    const double before = one.machine.time;
    live::run_loop(one, none, rate, running);
    const double passed = one.machine.time - before, clock = running.drawn_at;
    const std::string text = "session time at " + std::to_string(static_cast<int>(rate)) + " pictures/s of " +
                             std::to_string(static_cast<int>(1e3 * picture_time)) + " ms";
    return check(std::fabs(passed - clock) < 0.1, text.c_str(), passed, clock) &&
           check(running.frames <= 2 + rate * clock, "pictures, at most", running.frames, 2 + rate * clock);
}

bool replay_is_paced() {
    std::vector<live::step> steps{{30, {}}, {0, live::event{"interval", {12}}}, {5, {}}, {0, live::event{"gain", {3}}}};
    live::session one;
    std::optional<live::player> replay{std::in_place, steps};
    struct until_live : program {
        std::optional<live::player>& left;
        double took = 0;
        bool wait(live::steady::time_point until) {
            if (!left && took == 0) took = seconds_since(begin);
            return program::wait(until) && (left || frames < 40); // and a few live ones
        }
    } played{{.ends_after = 60}, replay};
    live::run_loop(one, replay, 30, played);
    const double expected = 30 / 30.0 + 5 * 0.1; // 12 ticks are 0.1 s
    return check(played.took > expected - 0.11 && played.took < expected + 10, "a recorded session takes, s",
                 played.took, expected) &&
           check(one.machine.settings.gain_db == 3, "its last event", static_cast<double>(one.machine.settings.gain_db),
                 3) &&
           check(played.frames == 40, "it goes on live, pictures", played.frames, 40);
}

bool replay_ends_at_once() {
    live::session one;
    std::optional<live::player> replay{std::in_place, std::vector<live::step>{{1'000'000, {}}}};
    program running{.ends_after = 0.5};
    live::run_loop(one, replay, 30, running);
    return check(seconds_since(running.begin) < 1.5, "a long session ends when asked, s", seconds_since(running.begin),
                 0.5);
}

bool nothing_without_a_viewer() {
    live::session one;
    std::optional<live::player> none;
    program running{.ends_after = 0.5, .looks = false};
    live::run_loop(one, none, 120, running);
    return check(running.frames == 0, "pictures that nobody looks at", running.frames, 0);
}

bool frozen_is_paced() {
    live::session one;
    one.frame(exec::par_unseq);
    one.apply({"freeze", {}});
    std::ostringstream text;
    live::recorder record{text};
    one.record = &record;
    std::optional<live::player> none;
    program running{.ends_after = 1};
    const double before = one.machine.time;
    live::run_loop(one, none, 30, running);
    return check(running.frames <= 32, "frozen pictures in a second, at most", running.frames, 32) &&
           check(one.machine.time == before, "its time stands still", one.machine.time, before);
}

bool refused_events_are_told() {
    live::session one;
    std::optional<live::player> replay{
        std::in_place, std::vector<live::step>{{0, live::event{"hold_probe", std::vector<float>(12)}}, {3, {}}}};
    program running{.ends_after = 0.5};
    live::run_loop(one, replay, 30, running);
    return check(running.refused == 1 && running.frames >= 3, "refused events of a recorded session", running.refused,
                 1);
}

} // namespace

int run() {
    bool holds = time_passes(10, 0) && time_passes(30, 0) && time_passes(120, 0); // 60 beats/min are 60
    holds = time_passes(30, 0.055) && time_passes(30, 0.4) && holds;              // slow pictures
    holds = replay_is_paced() && replay_ends_at_once() && nothing_without_a_viewer() && holds;
    holds = frozen_is_paced() && refused_events_are_told() && holds;
    return holds ? 0 : 1;
}

} // namespace loop_test
