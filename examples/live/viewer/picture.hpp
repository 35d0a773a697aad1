#ifndef INSONIFY_EXAMPLES_LIVE_VIEWER_PICTURE_HPP
#define INSONIFY_EXAMPLES_LIVE_VIEWER_PICTURE_HPP

#include "worker.hpp"
#include <GLFW/glfw3.h>
#include <algorithm>
#include <cstdio>
#include <imgui.h>
#include <string>

namespace live {

inline void upload(GLuint texture, uvec2 size, const std::vector<unsigned char>& bytes) {
    glBindTexture(GL_TEXTURE_2D, texture);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, static_cast<GLsizei>(size.x), static_cast<GLsizei>(size.y), 0, GL_RGBA,
                 GL_UNSIGNED_BYTE, bytes.data());
}
inline unsigned char byte_of(float level) { return static_cast<unsigned char>(255 * clamp(level, 0, 1) + 0.5F); }
/// @param opacity  of each pixel
inline void upload(GLuint texture, const colour_image& picture, const std::vector<std::uint8_t>& opacity) {
    std::vector<unsigned char> bytes;
    bytes.reserve(4 * picture.pixels.size());
    for (std::size_t k = 0; k < picture.pixels.size(); ++k) {
        for (int i = 0; i < 3; ++i) bytes.push_back(byte_of(picture.pixels[k][i]));
        bytes.push_back(opacity[k]);
    }
    upload(texture, picture.size, bytes);
}
inline void upload(GLuint texture, const image& picture) {
    std::vector<unsigned char> bytes;
    bytes.reserve(4 * picture.pixels.size());
    for (const float pixel : picture.pixels) {
        bytes.insert(bytes.end(), 3, byte_of(pixel));
        bytes.push_back(255);
    }
    upload(texture, picture.size, bytes);
}
inline ImTextureID texture_id(GLuint texture) {
    return reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(texture));
}
inline ImU32 colour_id(vec3 colour) { return IM_COL32(byte_of(colour.x), byte_of(colour.y), byte_of(colour.z), 255); }

/// The picture with its scales, and the callipers on it.
class picture_panel {
  public:
    enum class tool { distance, area };
    tool held = tool::distance;

    /// Draws into the present window, and turns clicks into events.
    void show(const shown_frame& frame, GLuint picture, GLuint strip, worker& scanner) {
        const bool has_strip = frame.strip.size.x > 0;
        const ImVec2 origin = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
        const float strip_height = has_strip ? 0.3F * room.y : 0;
        const auto columns = static_cast<float>(frame.screen.size.x), rows = static_cast<float>(frame.screen.size.y);
        scale_ = std::min((room.x - 150) / columns, (room.y - 24 - strip_height) / rows);
        left_ = origin.x + 34;
        top_ = origin.y;
        ImDrawList* const draw = ImGui::GetWindowDrawList();
        draw->AddImage(texture_id(picture), {left_, top_}, {left_ + columns * scale_, top_ + rows * scale_});
        depth_scale(frame, draw, origin.x);
        bars(frame, draw, left_ + columns * scale_, rows * scale_);
        callipers(frame, draw, scanner, {columns, rows});
        ImGui::SetCursorScreenPos({left_, top_ + rows * scale_ + 4});
        ImGui::Text("%.0f frames/s   contact %.0f %%", frame.seconds > 0 ? 1 / frame.seconds : 0.0,
                    static_cast<double>(100 * frame.contact));
        if (frame.frozen) {
            ImGui::SameLine();
            ImGui::TextColored({0.4F, 0.8F, 1, 1}, "  FROZEN");
        }
        if (frame.to_replay > 0) {
            ImGui::SameLine();
            ImGui::TextColored({1, 0.8F, 0.3F, 1}, "  REPLAY %.0f of %.0f", static_cast<double>(frame.replayed),
                               static_cast<double>(frame.to_replay));
        }
        if (has_strip) show_strip(frame, draw, strip, origin.x, top_ + rows * scale_ + 26, room.x, strip_height - 30);
    }

  private:
    static constexpr ImU32 gray = IM_COL32(200, 200, 200, 255), yellow = IM_COL32(255, 220, 90, 255);

    void depth_scale(const shown_frame& frame, ImDrawList* draw, float text_left) const {
        const auto y_of = [&](float depth) { return top_ + (depth - frame.top) / frame.pitch * scale_; };
        const int step = frame.depth > 80_mm ? 20 : 10;
        for (int mm = 0; static_cast<float>(mm) * 1_mm < frame.depth; mm += 5) {
            const float y = y_of(static_cast<float>(mm) * 1_mm);
            draw->AddLine({left_ - (mm % step == 0 ? 10.0F : 5.0F), y}, {left_, y}, gray);
            if (mm % step == 0) draw->AddText({text_left, y - 7}, gray, mm == 0 ? "mm" : std::to_string(mm).c_str());
        }
        const float focus = y_of(frame.focus), right = left_ + static_cast<float>(frame.screen.size.x) * scale_;
        draw->AddTriangleFilled({right + 2, focus}, {right + 11, focus - 6}, {right + 11, focus + 6}, yellow);
    }

    // Gray levels, colours of velocities and the names of the labels, to the right of the picture.
    static void bars(const shown_frame& frame, ImDrawList* draw, float right, float height) {
        const float top = ImGui::GetCursorScreenPos().y, x = right + 18;
        const ImU32 white = IM_COL32_WHITE, black = IM_COL32_BLACK;
        const bool colours = frame.shown == mode::colour || frame.shown == mode::power;
        const float gray_height = (colours ? 0.4F : 0.6F) * height;
        draw->AddRectFilledMultiColor({x, top}, {x + 12, top + gray_height}, white, white, black, black);
        draw->AddRect({x, top}, {x + 12, top + gray_height}, IM_COL32(90, 90, 90, 255));
        draw->AddText({x + 16, top}, gray, "grey");
        if (colours) {
            const float begin = top + gray_height + 24, part = 0.4F * height / 32;
            for (int i = 0; i < 32; ++i) {
                const float fraction = static_cast<float>(i) / 31;
                const vec3 colour =
                    frame.shown == mode::power ? power_colour(1 - fraction) : velocity_colour(1 - 2 * fraction);
                const float y = begin + static_cast<float>(i) * part;
                draw->AddRectFilled({x, y}, {x + 12, y + part + 1}, colour_id(colour));
            }
            const std::string fastest = std::to_string(std::lround(100 * frame.scale));
            const bool power = frame.shown == mode::power;
            draw->AddText({x + 16, begin}, gray, power ? "strong" : ("+" + fastest + " cm/s").c_str());
            draw->AddText({x + 16, begin + 13}, gray, power ? "" : "towards");
            draw->AddText({x + 16, begin + 32 * part - 26}, gray, power ? "" : "away");
            draw->AddText({x + 16, begin + 32 * part - 13}, gray, power ? "weak" : ("-" + fastest + " cm/s").c_str());
        }
        float y = top + gray_height + 12;
        for (const legend_entry& entry : frame.legend) {
            if (colours) break;
            draw->AddRectFilled({x, y + 2}, {x + 10, y + 12}, colour_id(entry.colour));
            draw->AddText({x + 14, y}, gray, entry.name.substr(0, 13).c_str());
            y += 15;
        }
    }

    void show_strip(const shown_frame& frame, ImDrawList* draw, GLuint strip, float text_left, float top, float width,
                    float height) const {
        const float right = text_left + width - 20;
        draw->AddImage(texture_id(strip), {left_ + 14, top}, {right, top + height});
        const auto label = [&](float value, float y) {
            draw->AddText({text_left, y}, gray, std::to_string(std::lround(value)).c_str());
        };
        label(frame.axes.upper, top);
        label(frame.axes.lower, top + height - 13);
        draw->AddText({text_left, top + 13}, gray, frame.axes.unit.c_str());
        const float span = frame.axes.lower - frame.axes.upper;
        if (frame.axes.upper * frame.axes.lower < 0) { // the baseline
            const float y = top + height * (0 - frame.axes.upper) / span;
            draw->AddLine({left_ + 14, y}, {right, y}, yellow);
            label(0, y - 7);
        }
        for (int second = 1; static_cast<float>(second) < frame.axes.seconds; ++second) {
            const float x = right - static_cast<float>(second) / frame.axes.seconds * (right - left_ - 14);
            draw->AddLine({x, top + height - 6}, {x, top + height}, gray);
        }
    }

    // A click begins or ends a distance, or adds a point to an outline, which a right click closes. What has been measured comes
    // back with the next frame, as it does from a recorded session.
    void callipers(const shown_frame& frame, ImDrawList* draw, worker& scanner, ImVec2 size) {
        const ImVec2 mouse = ImGui::GetIO().MousePos;
        const vec2 at{(mouse.x - left_) / scale_, (mouse.y - top_) / scale_};
        const bool over = ImGui::IsWindowHovered() && at.x >= 0 && at.y >= 0 && at.x < size.x && at.y < size.y;
        if (over && ImGui::IsMouseClicked(ImGuiMouseButton_Left)) {
            points_.push_back(at);
            if (held == tool::distance && points_.size() == 2) finish(scanner, "measure");
        }
        if (over && held == tool::area && points_.size() >= 3 && ImGui::IsMouseClicked(ImGuiMouseButton_Right))
            finish(scanner, "area");
        if (!points_.empty()) return draw_marks(draw, points_, false);
        if (!frame.measured) return;
        draw_marks(draw, frame.measured->points, frame.measured->closed);
        const ImVec2 beside = on_screen(frame.measured->points.back());
        draw->AddText({beside.x + 8, beside.y - 7}, yellow, measured_text(*frame.measured).c_str());
    }
    ImVec2 on_screen(vec2 point) const { return {left_ + point.x * scale_, top_ + point.y * scale_}; }
    void draw_marks(ImDrawList* draw, const std::vector<vec2>& points, bool closed) const {
        for (std::size_t i = 0; i < points.size(); ++i) {
            const ImVec2 here = on_screen(points[i]);
            draw->AddLine({here.x - 5, here.y}, {here.x + 5, here.y}, yellow);
            draw->AddLine({here.x, here.y - 5}, {here.x, here.y + 5}, yellow);
            if (i > 0) draw->AddLine(on_screen(points[i - 1]), here, yellow);
        }
        if (closed) draw->AddLine(on_screen(points.back()), on_screen(points.front()), yellow);
    }
    void finish(worker& scanner, const char* event_name) {
        event made{event_name};
        for (const vec2& point : points_) made.values.insert(made.values.end(), {point.x, point.y});
        scanner.push(made);
        points_.clear();
    }

    std::vector<vec2> points_{}; // clicked so far
    float scale_ = 1, left_ = 0, top_ = 0;
};

} // namespace live

#endif
