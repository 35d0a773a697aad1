#ifndef INSONIFY_DATASET_TEXT_HPP
#define INSONIFY_DATASET_TEXT_HPP

#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

/// Text for files: numbers that are read back as they were, and names from OBJ files, which may contain anything.
namespace dataset {

/// The shortest text that is read back as the same number.
template <class Number>
std::string digits(Number value) {
    char text[64];
    return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// The text itself where it is UTF-8; otherwise each byte as a character of Latin-1.
inline std::string as_utf8(std::string_view text) {
    const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U; };
    const auto follows = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
    std::string latin;
    bool valid = true;
    for (std::size_t i = 0; i < text.size();) {
        const unsigned lead = byte(i);
        const std::size_t length = lead < 0x80                   ? 1
                                   : lead >= 0xC2 && lead < 0xE0 ? 2
                                   : lead >> 4U == 0xEU          ? 3
                                   : lead >= 0xF0 && lead < 0xF5 ? 4
                                                                 : 0;
        valid = valid && length != 0;
        for (std::size_t k = 1; k < length; ++k) valid = valid && follows(i + k);
        // Neither overlong, nor a surrogate, nor beyond the last character.
        if ((lead == 0xE0 && byte(i + 1) < 0xA0) || (lead == 0xED && byte(i + 1) > 0x9F) ||
            (lead == 0xF0 && byte(i + 1) < 0x90) || (lead == 0xF4 && byte(i + 1) > 0x8F))
            valid = false;
        if (!valid) break;
        i += length;
    }
    if (valid) return std::string{text};
    for (const char letter : text) {
        const auto code = static_cast<unsigned char>(letter);
        if (code >= 0x80) latin += static_cast<char>(0xC0U | (code >> 6U));
        latin += static_cast<char>(code < 0x80 ? code : 0x80U | (code & 0x3FU));
    }
    return latin;
}

/// A string of JSON, with its quotation marks.
inline std::string json(std::string_view text) {
    std::string quoted{'"'};
    for (const char letter : text) {
        const auto code = static_cast<unsigned char>(letter);
        if (code < 0x20) {
            char escaped[8];
            std::snprintf(escaped, sizeof escaped, "\\u%04x", unsigned{code});
            quoted += escaped;
        } else {
            if (letter == '"' || letter == '\\') quoted += '\\';
            quoted += letter;
        }
    }
    return quoted + '"';
}

/// Text of an HTML page.
inline std::string html(std::string_view text) {
    std::string escaped;
    for (const char letter : text) switch (letter) {
        case '&':
            escaped += "&amp;";
            break;
        case '<':
            escaped += "&lt;";
            break;
        case '>':
            escaped += "&gt;";
            break;
        case '"':
            escaped += "&quot;";
            break;
        default:
            escaped += letter;
        }
    return escaped;
}

} // namespace dataset
#endif
