#ifndef INSONIFY_EXAMPLES_LIVE_LOOP_HPP
#define INSONIFY_EXAMPLES_LIVE_LOOP_HPP

#include "recording.hpp"
#include <chrono>
#include <cmath>
#include <concepts>
#include <optional>
#include <utility>

namespace live {

using steady = std::chrono::steady_clock;

/// When the turns of a loop are due. A turn that is late delays the next one: nothing is caught up.
class pacer {
  public:
    steady::time_point due() const { return due_; }
    /// The turn that is due begins.
    /// @param seconds  until the next one
    void turn(double seconds) {
        due_ = std::max(due_ + std::chrono::duration_cast<steady::duration>(std::chrono::duration<double>{seconds}),
                        steady::now());
    }

  private:
    steady::time_point due_ = steady::now();
};

/// Lets the time of a session pass as time does, however long frames take.
class session_clock {
  public:
    /// Sets how many ticks pass with the next frame. A pause of more than a second, as of a computer that slept, is left out.
    void follow(session& with, steady::time_point now = steady::now()) {
        const double second = session::max_ticks * session::tick;
        if (!runs_) time_ = now - seconds(session::usual_ticks * session::tick);
        if (now - time_ > seconds(2 * second)) time_ = now - seconds(second);
        runs_ = true;
        const double behind = std::chrono::duration<double>(now - time_).count() / session::tick;
        const auto ticks = static_cast<std::uint32_t>(std::clamp(std::round(behind), 1.0, 1.0 * session::max_ticks));
        time_ += seconds(ticks * session::tick);
        if (ticks != with.ticks) with.apply({"interval", {static_cast<float>(ticks)}});
    }
    /// Nothing is drawn for a while: the session's time stops until the next `follow`.
    void pause() { runs_ = false; }

  private:
    static steady::duration seconds(double count) {
        return std::chrono::duration_cast<steady::duration>(std::chrono::duration<double>{count});
    }
    steady::time_point time_{}; // up to which the session has come
    bool runs_ = false;
};

/// What a program does in `run_loop`.
template <class Program>
concept loop_program = requires(Program program, session& with, steady::time_point when, const std::exception& fault) {
    { program.wait(when) } -> std::same_as<bool>; // sleeps until then; false where the program ends
    { program.take(with) } -> std::same_as<bool>; // applies what users did; false where nobody looks: nothing is drawn
    { program.stops_replay() } -> std::same_as<bool>;
    program.draw(with);
    program.refuse(fault); // of a recorded event
};

/// The loop of a program that shows a session: plays a recording at its own pace, and goes on live at `rate` pictures a second.
/// @return  after `wait` has returned false
template <loop_program Program>
void run_loop(session& with, std::optional<player>& replay, double rate, Program& program) {
    pacer pace;
    session_clock clock;
    while (program.wait(pace.due())) {
        if (!program.take(with)) {
            clock.pause();
            pace.turn(1 / rate);
            continue;
        }
        if (replay && program.stops_replay()) replay.reset();
        if (replay) try {
                if (!replay->advance(with)) replay.reset();
            } catch (const std::exception& fault) {
                program.refuse(fault);
                continue;
            }
        if (!replay) clock.follow(with);
        pace.turn(replay ? with.ticks * session::tick : 1 / rate);
        program.draw(with);
    }
}

} // namespace live

#endif
