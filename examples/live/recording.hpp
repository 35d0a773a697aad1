#ifndef INSONIFY_EXAMPLES_LIVE_RECORDING_HPP
#define INSONIFY_EXAMPLES_LIVE_RECORDING_HPP

#include "anatomy.hpp"
#include <cinttypes>
#include <filesystem>
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
    if (word == "frame") {
        if (text >> rest) throw std::invalid_argument{"frame takes no number; did you mean: frames " + rest + "?"};
        return step{1, {}};
    }
    if (word != "frames") {
        const std::optional<event> one = parse_event(line);
        return one ? std::optional{step{0, one}} : std::nullopt;
    }
    text >> count;
    const float frames = parse_number("frames", count);
    if (!(frames >= 1 && frames <= 1e6F) || frames != std::floor(frames))
        throw std::invalid_argument{"frames: " + count + " is not a whole number from 1 to 1000000"};
    std::getline(text, rest);
    return step{static_cast<std::uint32_t>(frames), parse_event(rest)};
}

/// The anatomy of a recorded session.
struct recorded_anatomy {
    anatomy of{};
    std::uint64_t content = 0; ///< see `content_of`
};

/// The line of a recorded session that names its anatomy. The file is named as seen from the folder of the recording.
inline std::string anatomy_line(const recorded_anatomy& one, const std::filesystem::path& folder) {
    char numbers[64];
    std::snprintf(numbers, sizeof numbers, "%.9g %016" PRIx64, static_cast<double>(one.of.unit), one.content);
    const std::filesystem::path file = std::filesystem::absolute(one.of.file).lexically_normal();
    const std::filesystem::path seen =
        file.lexically_proximate(std::filesystem::absolute(folder / ".").lexically_normal());
    return std::string{"anatomy "} + numbers + ' ' + (one.of.skin.empty() ? "=" : one.of.skin) + ' ' + one.of.tissue +
           ' ' + one.of.background + ' ' + seen.generic_string();
}

/// The inverse of `anatomy_line`. @throws std::invalid_argument  for a line that is not whole
inline recorded_anatomy parse_anatomy(const std::string& line, const std::filesystem::path& folder) {
    std::istringstream text{line};
    std::string word, unit, content, file;
    recorded_anatomy read;
    text >> word >> unit >> content >> read.of.skin >> read.of.tissue >> read.of.background >> std::ws;
    std::getline(text, file);
    if (file.empty())
        throw std::invalid_argument{
            "anatomy takes the unit in metres, the content, side of the skin, tissue, background and "
            "file"};
    read.of.unit = parse_number("anatomy", unit);
    if (!(read.of.unit > 0)) throw std::invalid_argument{"anatomy: the unit " + unit + " is not above 0"};
    char* end = nullptr;
    read.content = std::strtoull(content.c_str(), &end, 16);
    if (*end != 0) throw std::invalid_argument{"anatomy: '" + content + "' is not a hexadecimal number"};
    if (read.of.skin == "=") read.of.skin.clear();
    read.of.file = (folder / file).lexically_normal().string();
    return read;
}

/// A recorded session.
struct recording {
    std::optional<recorded_anatomy> body{}; ///< none: the phantom of a nerve block
    std::vector<step> steps{};
};

/// Reads a file. @throws std::runtime_error  for a file that cannot be opened or has no event, or naming the line that is wrong
inline recording load_recording(const std::string& path) {
    std::ifstream file{path};
    if (!file) throw std::runtime_error{path + ": the recording cannot be opened"};
    recording read;
    std::size_t number = 0;
    for (std::string line; std::getline(file, line);) try {
            ++number;
            if (!line.empty() && line.back() == '\r') line.pop_back();
            if (line.rfind("anatomy ", 0) == 0) {
                read.body = parse_anatomy(line, std::filesystem::path{path}.parent_path());
                continue;
            }
            const std::optional<step> one = parse_step(line);
            if (!one) continue;
            if (one->what) control_of(*one->what);
            read.steps.push_back(*one);
        } catch (const std::invalid_argument& fault) {
            throw std::runtime_error{path + ":" + std::to_string(number) + ": " + fault.what()};
        }
    if (file.bad() || read.steps.empty())
        throw std::runtime_error{path + ": there is no event in it; a recorded session has lines such as: frames 30"};
    return read;
}

/// The body of a session: the anatomy that is asked for, or else that of the recording.
/// @param asked   without a file: as recorded
/// @param advice  what to do where the recorded anatomy is not there, or has changed
/// @throws std::runtime_error  as `load_anatomy`, and where the recorded anatomy is not there, or has changed since
inline loaded_anatomy
load_body(const anatomy& asked, const recording* played,
          const std::string& advice = "--obj FILE plays the session on another one, or on this one as it is now") {
    if (!asked.file.empty() || played == nullptr || !played->body) return load_anatomy(asked);
    const anatomy& recorded = played->body->of;
    if (!std::ifstream{recorded.file})
        throw std::runtime_error{recorded.file + ", on which the session was recorded, cannot be opened; " + advice};
    loaded_anatomy loaded = load_anatomy(recorded);
    if (content_of(loaded.body) != played->body->content)
        throw std::runtime_error{recorded.file + " has changed since the session was recorded; " + advice};
    return loaded;
}

/// Plays a recorded session frame by frame.
class player {
  public:
    explicit player(std::vector<step> steps) : steps_{std::move(steps)} {
        for (const step& one : steps_) frames_ += one.frames;
    }

    /// Applies the events before the next frame. @return false at the end, after the last events
    bool advance(session& with) {
        while (next_ < steps_.size()) {
            const step& one = steps_[next_];
            const bool draws = repeated_ < one.frames;
            if (draws)
                ++repeated_, ++played_;
            else
                ++next_, repeated_ = 0;
            if (one.what && (draws || one.frames == 0)) with.apply(*one.what);
            if (draws) return true;
        }
        return false;
    }
    std::uint64_t frames() const { return frames_; } ///< in all
    std::uint64_t played() const { return played_; } ///< so far

  private:
    std::vector<step> steps_;
    std::size_t next_ = 0;
    std::uint32_t repeated_ = 0; // of the frames of that step
    std::uint64_t frames_ = 0, played_ = 0;
};

} // namespace live

#endif
