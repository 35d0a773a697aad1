#ifndef INSONIFY_EXAMPLES_LIVE_SLICER_SEQUENCE_FILE_HPP
#define INSONIFY_EXAMPLES_LIVE_SLICER_SEQUENCE_FILE_HPP

#include "messages.hpp"
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <string>
#include <system_error>
#include <unistd.h>

namespace slicer {

/// Writes PLUS's sequence metafile, NAME.igs.mha, picture by picture. The file is complete after each picture, whatever
/// happens then: the header has room for `capacity` frames, filled with lines "Padding = ...", and the number of frames is
/// written last. A picture of another size, or one more than fit, begins another file: NAME-2.igs.mha.
class sequence_file {
  public:
    static constexpr std::uint32_t capacity = 1800; ///< frames in a file: a minute

    /// @throws std::system_error  where the file cannot be written
    explicit sequence_file(std::string name) : name_{std::move(name)} { check_name(); }
    sequence_file(const sequence_file&) = delete;
    sequence_file& operator=(const sequence_file&) = delete;
    ~sequence_file() { close(); }

    /// @param time  seconds since 1970
    void add(const image& picture, const scan_map& map, const pose& probe, const pose& needle, double time) {
        if (file_ < 0 || picture.size != size_ || frames_ == capacity) begin(picture.size, map.pitch);
        if (frames_ == 0) start_ = time;
        gray_.resize(picture.pixels.size());
        to_gray(picture, gray_.data());
        const std::uint64_t pixels = header_length_ + std::uint64_t{frames_} * gray_.size();
        write(pixels, gray_.data(), gray_.size());
        const std::string fields = frame_fields(map, probe, needle, time - start_);
        write(fields_begin_ + std::uint64_t{frames_} * room, fields.data(), fields.size());
        ++frames_;
        ++total_;
        const std::string count = dimensions();
        write(dimensions_begin_, count.data(), count.size());
    }

    std::uint32_t total() const { return total_; } ///< frames in all files

  private:
    static constexpr std::size_t room = 1536;        // bytes of the fields of a frame
    static constexpr std::size_t longest_line = 128; // of padding

    void check_name() const {
        const std::string ending = ".igs.mha";
        if (name_.size() <= ending.size() || name_.compare(name_.size() - ending.size(), ending.size(), ending) != 0)
            throw std::invalid_argument{"--record " + name_ + ": the name must end in .igs.mha"};
    }

    void begin(uvec2 size, vec2 pitch) {
        close();
        const std::string stem = name_.substr(0, name_.size() - 8);
        const std::string path = ++files_ == 1 ? name_ : stem + '-' + std::to_string(files_) + ".igs.mha";
        file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
        if (file_ < 0) throw std::system_error{errno, std::generic_category(), "--record " + path};
        size_ = size;
        frames_ = 0;
        char spacing[64];
        std::snprintf(spacing, sizeof spacing, "%.9g %.9g 1", 1e3 * static_cast<double>(pitch.x),
                      1e3 * static_cast<double>(pitch.y));
        std::string text = "ObjectType = Image\nNDims = 3\nAnatomicalOrientation = RAI\nBinaryData = True\n"
                           "BinaryDataByteOrderMSB = False\nCenterOfRotation = 0 0 0\nCompressedData = False\n";
        dimensions_begin_ = text.size();
        text += dimensions() + "ElementNumberOfChannels = 1\nElementSpacing = " + spacing +
                "\nElementType = MET_UCHAR\nKinds = domain domain list\nOffset = 0 0 0\n"
                "TransformMatrix = 1 0 0 0 1 0 0 0 1\nUltrasoundImageOrientation = MFA\n"
                "UltrasoundImageType = BRIGHTNESS\n";
        fields_begin_ = text.size();
        for (std::uint32_t frame = 0; frame < capacity; ++frame) text += padding(room);
        text += "ElementDataFile = LOCAL\n";
        header_length_ = text.size();
        write(0, text.data(), text.size());
    }

    // Always of the same length.
    std::string dimensions() const {
        std::string line =
            "DimSize = " + std::to_string(size_.x) + ' ' + std::to_string(size_.y) + ' ' + std::to_string(frames_);
        line.resize(48, ' ');
        return line + '\n';
    }

    // Whole lines of a total length of at least 12.
    static std::string padding(std::size_t length) {
        std::string text;
        while (length > 0) {
            const std::size_t line =
                length < 2 * longest_line ? length > longest_line ? length / 2 : length : longest_line;
            text += "Padding = " + std::string(line - 11, '.') + '\n';
            length -= line;
        }
        return text;
    }

    static std::string matrix_text(const mat3& axes, vec3 origin) {
        std::string text;
        char number[32];
        for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 4; ++column) {
                std::snprintf(number, sizeof number, "%.9g ",
                              static_cast<double>(column < 3 ? axes[column][row] : origin[row]));
                text += number;
            }
        return text + "0 0 0 1";
    }

    std::string frame_fields(const scan_map& map, const pose& probe, const pose& needle, double time) const {
        char prefix[32], seconds[64];
        std::snprintf(prefix, sizeof prefix, "Seq_Frame%04u_", frames_);
        std::snprintf(seconds, sizeof seconds, "%.6f", time);
        std::string text;
        const auto add_field = [&](const char* field, const std::string& value) {
            text += prefix + std::string{field} + " = " + value + '\n';
        };
        // Pixel indices to millimetres: the centre of the first pixel is that of the index 0.
        const vec2 pitch = 1e3F * map.pitch;
        const vec2 first = 1e3F * map.point(0, 0);
        const auto add_transform = [&](const std::string& name, const std::string& matrix) {
            add_field((name + "Transform").c_str(), matrix);
            add_field((name + "TransformStatus").c_str(), "OK");
        };
        add_field("FrameNumber", std::to_string(total_));
        add_field("Timestamp", seconds);
        add_field("UnfilteredTimestamp", seconds);
        add_transform("ImageToProbe", matrix_text({vec3{pitch.x, 0, 0}, vec3{0, 0, pitch.y}, vec3{0, -pitch.x, 0}},
                                                  {first.x, 0, first.y}));
        add_transform("ProbeToReference", matrix_text(probe.rotation, 1e3F * probe.translation));
        add_transform("NeedleTipToReference", matrix_text(needle.rotation, 1e3F * needle.translation));
        add_field("ImageStatus", "OK");
        return text + padding(room - text.size());
    }

    void write(std::uint64_t at, const void* from, std::size_t size) const {
        const auto* bytes_left = static_cast<const char*>(from);
        while (size > 0) {
            const ssize_t written = ::pwrite(file_, bytes_left, size, static_cast<off_t>(at));
            if (written < 0 && errno == EINTR) continue;
            if (written < 0) throw std::system_error{errno, std::generic_category(), "--record " + name_};
            bytes_left += written;
            at += static_cast<std::uint64_t>(written);
            size -= static_cast<std::size_t>(written);
        }
    }
    void close() {
        if (file_ >= 0) ::close(file_);
        file_ = -1;
    }

    std::string name_;
    int file_ = -1;
    uvec2 size_{0, 0};
    std::uint32_t frames_ = 0, total_ = 0, files_ = 0;
    double start_ = 0;
    std::uint64_t dimensions_begin_ = 0, fields_begin_ = 0, header_length_ = 0;
    bytes gray_{};
};

} // namespace slicer

#endif
