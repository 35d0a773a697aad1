#ifndef INSONIFY_CORE_ERROR_HPP
#define INSONIFY_CORE_ERROR_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

namespace insonify::inline INSONIFY_ABI {

namespace detail {

/// A number with up to so many significant digits and, in every locale, a decimal point.
inline std::string number_text(float value, int digits = 4) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", digits, static_cast<double>(value));
    std::string number{text};
    std::replace(number.begin(), number.end(), ',', '.');
    return number;
}

/// A part of a message: text, or a number, with up to 4 significant digits where it is a fraction.
class message_part {
  public:
    message_part(const char* text) : message_part{std::string_view{text}} {}
    message_part(std::string_view text) : kind_{kind::text}, text_{text.data()}, number_{text.size()} {}
    message_part(const std::string& text) : message_part{std::string_view{text}} {}
    message_part(float number) : kind_{kind::fraction}, number_{__builtin_bit_cast(std::uint32_t, number)} {}
    message_part(char) = delete; // neither text nor a number
    message_part(bool) = delete;
    template <std::integral Number>
    message_part(Number number)
        : kind_{std::cmp_less(number, 0) ? kind::negative : kind::count}, number_{static_cast<std::uint64_t>(number)} {}

    void append_to(std::string& whole) const {
        if (kind_ == kind::text) whole.append(text_, number_);
        if (kind_ == kind::count) whole += std::to_string(number_);
        if (kind_ == kind::negative) whole += std::to_string(static_cast<std::int64_t>(number_));
        if (kind_ == kind::fraction)
            whole += number_text(__builtin_bit_cast(float, static_cast<std::uint32_t>(number_)));
    }

  private:
    enum class kind : std::uint8_t { text, count, negative, fraction };
    kind kind_;
    const char* text_ = nullptr;
    std::uint64_t number_; // its bits; of a text how many characters it has
};

/// The parts of a message in one string.
inline std::string joined(std::initializer_list<message_part> parts) {
    std::string whole;
    for (const message_part& part : parts) part.append_to(whole);
    return whole;
}

/// An error with a message of parts: usage_error{"line ", 3, " has no sample"}.
template <class Standard>
struct composed_error : Standard {
    using Standard::Standard;
    composed_error(std::initializer_list<message_part> parts) : Standard{joined(parts)} {}
};

} // namespace detail

/// A file could not be read or written, or its content is invalid. The message names the file and the line or object.
struct io_error : detail::composed_error<std::runtime_error> {
    using composed_error::composed_error;
};

/// An invalid mesh, pose or primitive. `validate` reports the defects of a mesh.
struct geometry_error : detail::composed_error<std::runtime_error> {
    using composed_error::composed_error;
};

/// A setting that is out of range, or a call out of order, such as tracing a scene that was not built.
struct usage_error : detail::composed_error<std::logic_error> {
    using composed_error::composed_error;
};

namespace detail {

/// "3 holes", "1 hole".
inline std::string counted(std::size_t count, const char* one, const char* many) {
    return std::to_string(count) + ' ' + (count == 1 ? one : many);
}

} // namespace detail
} // namespace insonify::inline INSONIFY_ABI

#include <insonify/core/restore_macros.hpp>

#endif
