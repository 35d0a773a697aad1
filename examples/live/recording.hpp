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
    anatomy_file of{};
    std::uint64_t content = 0; ///< see `content_of`
};

/// The line of a recorded session that names its anatomy. The file is named as seen from the folder of the recording.
inline std::string anatomy_line(const recorded_anatomy& one, const std::filesystem::path& folder) {
    char numbers[64];
    std::snprintf(numbers, sizeof numbers, "%.9g %016" PRIx64, static_cast<double>(one.of.unit), one.content);
    const std::filesystem::path file = std::filesystem::absolute(one.of.file).lexically_normal();
    const std::filesystem::path seen =
        file.lexically_proximate(std::filesystem::absolute(folder / ".").lexically_normal());
    std::string settings = one.of.side.empty() ? "=" : one.of.side;
    if (one.of.repair) settings += ",repair";
    const auto add = [&settings](const char* name, float value) {
        char text[48];
        std::snprintf(text, sizeof text, ",%s=%.9g", name, static_cast<double>(value));
        settings += text;
    };
    if (one.of.pennation != 0) add("pennation", one.of.pennation);
    if (one.of.skin != 0) add("skin", one.of.skin);
    return std::string{"anatomy "} + numbers + ' ' + settings + ' ' + one.of.tissue + ' ' + one.of.background + ' ' +
           seen.generic_string();
}

/// The inverse of `anatomy_line`. @throws std::invalid_argument  for a line that is not whole
inline recorded_anatomy parse_anatomy(const std::string& line, const std::filesystem::path& folder) {
    std::istringstream text{line};
    std::string word, unit, content, settings, file;
    recorded_anatomy read;
    text >> word >> unit >> content >> settings >> read.of.tissue >> read.of.background >> std::ws;
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
    read.of.skin = 0;
    std::istringstream all{settings}; // the side of the skin, and what else was asked for
    std::getline(all, read.of.side, ',');
    if (read.of.side == "=") read.of.side.clear();
    for (std::string one; std::getline(all, one, ',');) {
        const auto value = [&one] { return parse_number("anatomy", one.substr(one.find('=') + 1)); };
        if (one == "repair")
            read.of.repair = true;
        else if (one.starts_with("pennation="))
            read.of.pennation = value();
        else if (one.starts_with("skin="))
            read.of.skin = value();
        else
            throw std::invalid_argument{"anatomy: '" + one +
                                        "' is unknown; repair, pennation=ANGLE or skin=METRES "
                                        "may follow the side of the skin"};
    }
    read.of.file = (folder / file).lexically_normal().string();
    return read;
}

/// The line of a recorded session that names parameters of a region, and its inverse. @{
inline std::string parameters_line(const region_parameters& one) {
    std::ostringstream text;
    text.precision(9);
    text << "parameters " << one.region;
    for (const auto& [name, value] : one.values) text << ' ' << name << '=' << value;
    return text.str();
}
/// @throws std::invalid_argument  for a word that is no name and value  @throws usage_error  as `checked`
inline region_parameters parse_parameters(const std::string& line) {
    std::istringstream text{line};
    std::string word, region;
    ::anatomy::values values;
    text >> word >> region;
    while (text >> word) {
        const std::size_t equals = word.find('=');
        if (equals == std::string::npos)
            throw std::invalid_argument{"parameters: '" + word + "' is not a name and its value, such as fat=0.006"};
        const std::string name = word.substr(0, equals);
        if (!values.emplace(name, parse_number("parameters", word.substr(equals + 1))).second)
            throw std::invalid_argument{"parameters: `" + name + "` is given twice"};
    }
    return checked(region, values);
}
/// @}

/// A recorded session.
struct recording {
    std::optional<recorded_anatomy> body{}; ///< none: the first case
    region_parameters given{};              ///< of all bodies of a region
    std::vector<step> steps{};
};

/// A message without bytes that are no letters, of a file that may be no text.
inline std::string printable(std::string text) {
    constexpr std::size_t longest = 200;
    if (text.size() > longest) text = text.substr(0, longest) + "...";
    for (char& letter : text)
        if (letter < ' ' || letter > '~') letter = '?';
    return text;
}

/// Reads a file.
/// @throws std::runtime_error  for a file that cannot be opened or has no event, or naming the line that is wrong: that is
/// unknown, or measures where there is no picture yet
inline recording load_recording(const std::string& path) {
    if (std::filesystem::is_directory(path)) throw std::runtime_error{path + ": this is a folder, not a recording"};
    std::ifstream file{path};
    if (!file) throw std::runtime_error{path + ": the recording cannot be opened"};
    recording read;
    std::size_t number = 0;
    bool has_picture = false, in_case = true;
    for (std::string line; std::getline(file, line);) try {
            ++number;
            if (!line.empty() && line.back() == '\r') line.pop_back();
            if (line.rfind("anatomy ", 0) == 0) {
                read.body = parse_anatomy(line, std::filesystem::path{path}.parent_path());
                in_case = false;
                continue;
            }
            if (line.rfind("parameters ", 0) == 0) {
                read.given = parse_parameters(line);
                continue;
            }
            const std::optional<step> one = parse_step(line);
            if (!one) continue;
            if (one->what) {
                const control& known = control_of(*one->what);
                if (measures(known) && !has_picture) throw std::invalid_argument{one->what->name + ": " + no_picture};
                if (known.group == "Case") { // of a mesh of one's own there is no other patient
                    in_case = in_case || one->what->name == "case";
                    has_picture = has_picture && !in_case;
                }
            }
            has_picture = has_picture || one->frames > 0;
            read.steps.push_back(*one);
        } catch (const std::logic_error& fault) {
            throw std::runtime_error{path + ":" + std::to_string(number) + ": " + printable(fault.what())};
        }
    if (file.bad() || read.steps.empty())
        throw std::runtime_error{path + ": there is no event in it; a recorded session has lines such as: frames 30"};
    return read;
}

/// What a session examines: what is asked for, or else what the recording begins with.
/// @param advice  what to do where the recorded anatomy is not there, or has changed
/// @throws std::runtime_error  as `load_anatomy`, and where the recorded anatomy is not there, or has changed since
inline loaded_anatomy
load_body(const anatomy_choice& asked, const recording* played,
          const std::string& advice = "--obj FILE plays the session on another one, or on this one as it is now") {
    if (!asked.file.file.empty()) return load_anatomy(asked.file);
    if (asked.case_number || played == nullptr) return {asked};
    if (!played->body) return {{.given = played->given}};
    const anatomy_file& recorded = played->body->of;
    if (!std::ifstream{recorded.file})
        throw std::runtime_error{recorded.file + ", on which the session was recorded, cannot be opened; " + advice};
    loaded_anatomy loaded = load_anatomy(recorded);
    if (loaded.content != played->body->content)
        throw std::runtime_error{recorded.file + " has changed since the session was recorded; " + advice};
    loaded.given = played->given;
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
