#ifndef INSONIFY_EXAMPLES_LIVE_SLICER_REQUESTS_HPP
#define INSONIFY_EXAMPLES_LIVE_SLICER_REQUESTS_HPP

#include "messages.hpp"
#include <array>
#include <optional>
#include <stdexcept>

/// What clients send. Bytes are not trusted: every length is checked before it is used.
namespace slicer {

inline constexpr std::size_t header_size = 58;
inline constexpr std::size_t max_body = 128 * 1024;       ///< of the messages that are understood
inline constexpr std::size_t max_ignored_body = 64 << 20; ///< of all others, which are skipped
inline constexpr std::size_t command_header_size = 138;

/// Bytes that are not OpenIGTLink: what follows cannot be read either, so the connection is closed.
struct broken_stream : std::runtime_error {
    using runtime_error::runtime_error;
};
/// A message that is refused; the next one may be right. `code` is that of STATUS.
struct refused_message : std::runtime_error {
    int code;
    refused_message(int status, const std::string& sentence) : runtime_error{sentence}, code{status} {}
};

struct header {
    std::uint16_t version = 1;
    std::string type{}, device{};
    std::uint64_t body_size = 0, crc = 0;
};

namespace detail {

/// Reads big-endian numbers; a number beyond the end is a refused message.
class reader {
  public:
    reader(const unsigned char* first, std::size_t size) : at_{first}, left_{size} {}

    std::uint64_t number(std::size_t size) {
        const unsigned char* const from = skip(size);
        std::uint64_t value = 0;
        for (std::size_t i = 0; i < size; ++i) value = value << 8 | from[i];
        return value;
    }
    float real() {
        const auto bits = static_cast<std::uint32_t>(number(4));
        float value = 0;
        std::memcpy(&value, &bits, sizeof value);
        return value;
    }
    /// A field of a fixed size that ends at its first 0; other control characters become question marks.
    std::string text(std::size_t size) {
        const auto* const from = reinterpret_cast<const char*>(skip(size));
        std::string value{from, strnlen(from, size)};
        for (char& letter : value)
            if (static_cast<unsigned char>(letter) < ' ' && letter != '\n' && letter != '\t') letter = '?';
        return value;
    }
    const unsigned char* skip(std::size_t size) {
        if (size > left_)
            throw refused_message{igtl::StatusMessage::STATUS_UNKNOWN_ERROR, "the message is shorter than it says"};
        const unsigned char* const from = at_;
        at_ += size;
        left_ -= size;
        return from;
    }
    std::size_t left() const { return left_; }

  private:
    const unsigned char* at_;
    std::size_t left_;
};

} // namespace detail

inline bool is_understood(const std::string& type) {
    for (const char* const known :
         {"TRANSFORM", "COMMAND", "STRING", "GET_STATUS", "GET_IMAGE", "GET_TRANS", "STT_IMAGE", "STP_IMAGE"})
        if (type == known) return true;
    return false;
}

/// @param first  `header_size` bytes
/// @throws broken_stream  where they are not a header, or the body is longer than is accepted
inline header read_header(const unsigned char* first) {
    detail::reader in{first, header_size};
    header read;
    read.version = static_cast<std::uint16_t>(in.number(2));
    read.type = in.text(12);
    read.device = in.text(20);
    in.number(8); // time stamp
    read.body_size = in.number(8);
    read.crc = in.number(8);
    if (read.version < 1 || read.version > 3 || read.type.empty() ||
        read.type.find_first_not_of("ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_") != std::string::npos)
        throw broken_stream{"this is not a header of OpenIGTLink"};
    if (read.body_size > (is_understood(read.type) ? max_body : max_ignored_body))
        throw broken_stream{"a body of " + std::to_string(read.body_size) + " bytes is too long for " + read.type};
    return read;
}

/// The content of a body, without extended header and metadata.
/// @throws refused_message  for a wrong checksum or impossible lengths
inline bytes read_content(const header& head, bytes body) {
    if (crc64(body.data(), body.size(), 0) != head.crc)
        throw refused_message{igtl::StatusMessage::STATUS_CHECKSUM_ERROR, head.type + ": the checksum is wrong"};
    if (head.version < 2 || body.empty()) return body;
    detail::reader in{body.data(), body.size()};
    const std::size_t extended = in.number(2), index = in.number(2), values = in.number(4);
    if (extended < 12 || extended > body.size() || index + values > body.size() - extended)
        throw refused_message{igtl::StatusMessage::STATUS_UNKNOWN_ERROR,
                              head.type + ": the extended header has impossible lengths"};
    return {body.begin() + static_cast<std::ptrdiff_t>(extended),
            body.end() - static_cast<std::ptrdiff_t>(index + values)};
}

/// The pose of TRANSFORM. Small errors of rounding and calibration are removed.
/// @throws refused_message  for a matrix that is not a rigid transform
inline pose read_transform(const header& head, const bytes& content) {
    detail::reader in{content.data(), content.size()};
    std::array<vec3, 4> columns{};
    for (vec3& column : columns) column = {in.real(), in.real(), in.real()};
    const refused_message refused{igtl::StatusMessage::STATUS_CONFIG_ERROR,
                                  head.device + ": the matrix is not a rigid transform in millimetres"};
    pose at;
    try {
        at = orthonormalised({mat3{columns[0], columns[1], columns[2]}, 1e-3F * columns[3]});
    } catch (const geometry_error&) {
        throw refused;
    }
    for (int i = 0; i < 3; ++i)
        if (!(length(at.rotation[i] - columns[static_cast<std::size_t>(i)]) < 0.02F)) throw refused;
    return at;
}

/// A command by COMMAND or STRING.
struct command {
    bool is_string = false;
    std::uint32_t id = 0;
    std::string name{}, text{};
};

/// @throws refused_message  where a length is wrong
inline command read_command(const header& head, const bytes& content) {
    detail::reader in{content.data(), content.size()};
    command read;
    read.is_string = head.type == "STRING";
    if (!read.is_string) {
        read.id = static_cast<std::uint32_t>(in.number(4));
        read.name = in.text(128);
    }
    in.number(2); // encoding
    const std::size_t size = in.number(read.is_string ? 2 : 4);
    read.text = in.text(size);
    return read;
}

} // namespace slicer

#endif
