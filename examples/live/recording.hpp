#ifndef INSONIFY_EXAMPLES_LIVE_RECORDING_HPP
#define INSONIFY_EXAMPLES_LIVE_RECORDING_HPP

#include "session.hpp"
#include <fstream>
#include <string>
#include <vector>

namespace live {

/// A line of a recorded session: an event; "frame"; "frames N"; or "frames N slide 0.1 0", which applies the event before each
/// of N frames.
struct step {
    std::uint32_t frames = 0;    ///< to draw
    std::optional<event> what{}; ///< to apply: once where nothing is drawn, else before each frame
};

/// Reads a line; none from an empty line or a comment.
/// @throws std::invalid_argument  for a line that is none of these
inline std::optional<step> parse_step(const std::string& line) {
    std::istringstream text{line.substr(0, line.find('#'))};
    std::string word, count, rest;
    text >> word;
    if (word == "frame") return step{1, {}};
    if (word != "frames") {
        const std::optional<event> one = parse_event(line);
        return one ? std::optional{step{0, one}} : std::nullopt;
    }
    text >> count;
    const float frames = parse_number("frames", count);
    if (!(frames >= 1 && frames <= 1e6F)) throw std::invalid_argument{"frames: " + count + " is not 1 to 1000000"};
    std::getline(text, rest);
    return step{static_cast<std::uint32_t>(frames), parse_event(rest)};
}

/// Reads a file. @throws std::runtime_error  for a file that cannot be opened, or naming the line that is wrong
inline std::vector<step> load_recording(const std::string& path) {
    std::ifstream file{path};
    if (!file) throw std::runtime_error{path + ": the recording cannot be opened"};
    std::vector<step> steps;
    std::size_t number = 0;
    for (std::string line; std::getline(file, line);) try {
            ++number;
            const std::optional<step> one = parse_step(line);
            if (!one) continue;
            if (one->what) control_of(*one->what);
            steps.push_back(*one);
        } catch (const std::invalid_argument& fault) {
            throw std::runtime_error{path + ":" + std::to_string(number) + ": " + fault.what()};
        }
    return steps;
}

/// Plays a recording. @param draw  draw(session) draws a frame, and returns whether to go on
template <class Draw>
void play(const std::vector<step>& steps, session& with, const Draw& draw) {
    for (const step& one : steps) {
        if (one.frames == 0 && one.what) with.apply(*one.what);
        for (std::uint32_t i = 0; i < one.frames; ++i) {
            if (one.what) with.apply(*one.what);
            if (!draw(with)) return;
        }
    }
}

} // namespace live

#endif
