#ifndef INSONIFY_EXAMPLES_LIVE_SLICER_MESSAGES_HPP
#define INSONIFY_EXAMPLES_LIVE_SLICER_MESSAGES_HPP

#include <insonify/insonify.hpp>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <igtlImageMessage.h>
#include <igtlStatusMessage.h>
#include <igtlStringMessage.h>
#include <igtlTransformMessage.h>
#include <igtl_util.h>
#include <string>
#include <utility>
#include <vector>

/// What the server sends. The library of OpenIGTLink packs it, except for the messages of version 3, which Debian's release
/// does not have: COMMAND is answered by RTS_COMMAND with an extended header and metadata.
namespace slicer {

using namespace insonify;
using bytes = std::vector<unsigned char>;

inline constexpr const char* server_name = "insonify"; ///< device name of STATUS

/// Seconds since 1970.
inline double now() {
    return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

/// A pose as a matrix in millimetres.
inline void to_matrix(const pose& at, igtl::Matrix4x4& matrix) {
    for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) matrix[row][column] = at.rotation[column][row];
        matrix[row][3] = 1e3F * at.translation[row];
        matrix[3][row] = 0;
    }
    matrix[3][3] = 1;
}

namespace detail {

/// The bytes of a message of the library.
inline bytes packed(igtl::MessageBase& message, const char* device, double time) {
    message.SetDeviceName(device);
    const igtl::TimeStamp::Pointer stamp = igtl::TimeStamp::New();
    stamp->SetTime(time);
    igtl::TimeStamp::Pointer same = stamp;
    message.SetTimeStamp(same);
    message.Pack();
    const auto* const first = static_cast<const unsigned char*>(message.GetPackPointer());
    return {first, first + message.GetPackSize()};
}

inline void append(bytes& to, std::uint64_t value, int size) {
    for (int byte = size - 1; byte >= 0; --byte) to.push_back(static_cast<unsigned char>(value >> 8 * byte));
}
inline void append(bytes& to, const std::string& text, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) to.push_back(i < text.size() ? static_cast<unsigned char>(text[i]) : 0);
}

} // namespace detail

/// A header and its body; the time stamp is now.
inline bytes pack(std::uint16_t version, const std::string& type, const std::string& device, bytes body) {
    bytes message;
    const double time = now();
    const auto seconds = static_cast<std::uint64_t>(time);
    detail::append(message, version, 2);
    detail::append(message, type, 12);
    detail::append(message, device, 20);
    detail::append(message, seconds, 4);
    detail::append(message, static_cast<std::uint64_t>((time - static_cast<double>(seconds)) * 4294967296.0), 4);
    detail::append(message, body.size(), 8);
    detail::append(message, crc64(body.data(), body.size(), 0), 8);
    message.insert(message.end(), body.begin(), body.end());
    return message;
}

/// TRANSFORM: local to world, millimetres.
inline bytes pack_transform(const char* device, const pose& at, double time) {
    const igtl::TransformMessage::Pointer message = igtl::TransformMessage::New();
    igtl::Matrix4x4 matrix;
    to_matrix(at, matrix);
    message->SetMatrix(matrix);
    return detail::packed(*message, device, time);
}

/// The pixels of a picture in 8 bits, row by row from the top.
inline void to_gray(const image& picture, unsigned char* gray) {
    for (std::size_t i = 0; i < picture.pixels.size(); ++i)
        gray[i] = static_cast<unsigned char>(255 * clamp(picture.pixels[i], 0, 1) + 0.5F);
}

/// The axes of the picture and its middle in the world: i to the right, j down, k = i x j; metres.
inline pose image_pose(const scan_map& map, const pose& probe) {
    return {mat3{probe.rotation[0], probe.rotation[2], -probe.rotation[1]},
            probe.point({map.centre.x, 0, map.centre.y})};
}

/// IMAGE: 8-bit gray values, pitch and slice in the world. As in all images of OpenIGTLink, the position is that of the
/// middle of the image, (size - 1) / 2 in pixels.
inline bytes pack_image(const char* device, const image& picture, const scan_map& map, const pose& probe, double time) {
    const igtl::ImageMessage::Pointer message = igtl::ImageMessage::New();
    const int columns = static_cast<int>(picture.size.x), rows = static_cast<int>(picture.size.y);
    message->SetDimensions(columns, rows, 1);
    message->SetSubVolume(columns, rows, 1, 0, 0, 0);
    const vec2 pitch = 1e3F * map.pitch;
    message->SetSpacing(pitch.x, pitch.y, pitch.x);
    message->SetScalarTypeToUint8();
    message->AllocateScalars();
    to_gray(picture, static_cast<unsigned char*>(message->GetScalarPointer()));
    igtl::Matrix4x4 matrix;
    to_matrix(image_pose(map, probe), matrix);
    message->SetMatrix(matrix);
    return detail::packed(*message, device, time);
}

/// STATUS: a code of igtl::StatusMessage and a sentence.
inline bytes pack_status(int code, const std::string& sentence) {
    const igtl::StatusMessage::Pointer message = igtl::StatusMessage::New();
    message->SetCode(code);
    message->SetSubCode(0); // not initialised by the library
    message->SetErrorName(code == igtl::StatusMessage::STATUS_OK ? "OK" : "Error");
    message->SetStatusString(sentence.c_str());
    return detail::packed(*message, server_name, now());
}

/// STRING, at most 65535 bytes.
inline bytes pack_string(const std::string& device, std::string text) {
    const igtl::StringMessage::Pointer message = igtl::StringMessage::New();
    text.resize(std::min<std::size_t>(text.size(), 65535));
    message->SetString(text);
    return detail::packed(*message, device.c_str(), now());
}

/// RTS_IMAGE, which answers STT_IMAGE and STP_IMAGE: success.
inline bytes pack_accepted(const std::string& type) { return pack(1, type, server_name, {0}); }

using metadata = std::vector<std::pair<std::string, std::string>>;

/// RTS_COMMAND.
/// @param version  of the header of the COMMAND; metadata needs 2
inline bytes pack_command_reply(std::uint16_t version, const std::string& device, std::uint32_t id,
                                const std::string& name, const std::string& text, const metadata& data) {
    constexpr std::uint16_t ascii = 3; // the MIB enumeration of US-ASCII
    bytes content, index, values;
    detail::append(content, id, 4);
    detail::append(content, name, 128);
    detail::append(content, ascii, 2);
    detail::append(content, text.size(), 4);
    detail::append(content, text, text.size());
    if (version < 2) return pack(version, "RTS_COMMAND", device, std::move(content));
    detail::append(index, data.size(), 2);
    for (const auto& [key, value] : data) {
        detail::append(index, key.size(), 2);
        detail::append(index, ascii, 2);
        detail::append(index, value.size(), 4);
        detail::append(values, key, key.size());
        detail::append(values, value, value.size());
    }
    bytes body;
    detail::append(body, 12, 2); // of the extended header
    detail::append(body, index.size(), 2);
    detail::append(body, values.size(), 4);
    detail::append(body, 0, 4); // identifier of the message
    for (const bytes* const part : {&content, &index, &values}) body.insert(body.end(), part->begin(), part->end());
    return pack(version, "RTS_COMMAND", device, std::move(body));
}

} // namespace slicer

#endif
