#ifndef INSONIFY_EXAMPLES_LIVE_EVENT_HPP
#define INSONIFY_EXAMPLES_LIVE_EVENT_HPP

#include <insonify/core/math.hpp>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace live {

/// What a user does: a word and its numbers, in the units of `controls`.
struct event {
    std::string name{};
    std::vector<float> values{};
};

/// A finite number, which is the whole of a word. @throws std::invalid_argument  for anything else
inline float parse_number(const std::string& name, const std::string& word) {
    char* end = nullptr;
    const float value = std::strtof(word.c_str(), &end);
    if (end != word.c_str() + word.size() || !std::isfinite(value))
        throw std::invalid_argument{name + ": '" + word + "' is not a finite number"};
    return value;
}

/// Reads an event from a line such as "slide 2 -1"; none from an empty line or a comment, which begins with #.
/// @throws std::invalid_argument  for a word where a number belongs
inline std::optional<event> parse_event(const std::string& line) {
    std::istringstream text{line.substr(0, line.find('#'))};
    event read;
    if (!(text >> read.name)) return std::nullopt;
    for (std::string word; text >> word;) read.values.push_back(parse_number(read.name, word));
    return read;
}

/// The inverse of `parse_event`: a line without its end. Numbers are written exactly.
inline std::string event_line(const event& one) {
    std::ostringstream text;
    text.precision(9);
    text << one.name;
    for (const float value : one.values) text << ' ' << value;
    return text.str();
}

/// Writes events and frames as a recorded session: see recording.hpp. What was written can be replayed after a crash, which
/// loses at most the last second.
class recorder {
  public:
    explicit recorder(std::ostream& to) : to_{to} {}
    recorder(const recorder&) = delete;
    recorder& operator=(const recorder&) = delete;
    ~recorder() { write_frames(); }

    void add(const event& one) {
        write_frames();
        to_ << event_line(one) << std::endl;
    }
    void add_frame() {
        if (++frames_ == frames_per_line) write_frames();
    }

  private:
    static constexpr std::uint32_t frames_per_line = 30;

    void write_frames() {
        if (frames_ == 1) to_ << "frame" << std::endl;
        if (frames_ > 1) to_ << "frames " << frames_ << std::endl;
        frames_ = 0;
    }

    std::ostream& to_;
    std::uint32_t frames_ = 0; // since the last line
};

} // namespace live

#endif
