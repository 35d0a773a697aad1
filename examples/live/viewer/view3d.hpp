#ifndef INSONIFY_EXAMPLES_LIVE_VIEWER_VIEW3D_HPP
#define INSONIFY_EXAMPLES_LIVE_VIEWER_VIEW3D_HPP

#include "picture.hpp"

namespace live {

/// The anatomy, the probe with its picture, and the needle, drawn by OpenGL 2.
class view3d {
  public:
    float yaw = -0.5F, pitch = 0.5F, distance = 0; ///< of the camera, about `target`, the middle of the anatomy
    vec3 target{0, 0, 0};
    bool cuts = true; ///< whether what hides the picture is left out: see `is_cut`

    /// Takes another anatomy, and sees all of a small one; of a larger one what is below the probe.
    void show(const shown_anatomy& anatomy, vec3 probe) {
        for (const part& one : parts_) glDeleteLists(one.list, 1);
        parts_.clear();
        for (const shown_anatomy::part& one : anatomy.parts) {
            const GLuint list = glGenLists(1);
            glNewList(list, GL_COMPILE);
            draw_mesh(one.surface, pose{});
            glEndList();
            parts_.push_back({list, {one.colour.x, one.colour.y, one.colour.z, one.opacity}, one.is_cut});
        }
        const aabb& whole = anatomy.box;
        if (!whole.empty()) target = 0.5F * (whole.lower + whole.upper);
        all_ = 1.4F * (whole.empty() ? 100_mm : length(whole.size()));
        constexpr float near = 420_mm;
        distance = min(all_, near);
        if (all_ > near) target = probe + vec3{0, 0, 40_mm};
    }

    /// Multiplies the distance of the camera.
    void zoom(float factor) { distance = std::clamp(distance * factor, 30_mm, std::max(3 * all_, 30_mm)); }

    /// Draws into a part of the window, in pixels from its lower left corner.
    void draw(int x, int y, int width, int height, const shown_frame& frame, GLuint picture) {
        left_ = x;
        width_ = width;
        height_ = height;
        glViewport(x, y, width, height);
        glScissor(x, y, width, height);
        glEnable(GL_SCISSOR_TEST);
        glClearColor(0.12F, 0.13F, 0.16F, 1);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        glEnable(GL_DEPTH_TEST);
        glEnable(GL_BLEND);
        glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
        place_camera(static_cast<double>(width) / height);

        glEnable(GL_LIGHTING);
        glEnable(GL_LIGHT0);
        glEnable(GL_COLOR_MATERIAL);
        glLightModeli(GL_LIGHT_MODEL_TWO_SIDE, 1);
        glEnable(GL_NORMALIZE);
        place_cut(frame);
        for (const part& one : parts_) {
            if (one.paint.alpha < 1) continue;
            (cuts && one.is_cut ? glEnable : glDisable)(GL_CLIP_PLANE0);
            draw_part(one);
        }
        glDisable(GL_CLIP_PLANE0);
        glColor4f(0.8F, 0.85F, 0.9F, 1);
        draw_mesh(make_needle(needle_diameter(frame.gauge), patient::needle_length, {.bevel = frame.bevel}),
                  frame.needle);
        glColor4f(0.35F, 0.55F, 0.75F, 1);
        draw_mesh(frame.anatomy->probe, frame.probe);
        glDisable(GL_LIGHTING);
        draw_slice(frame, picture);
        glEnable(GL_LIGHTING);
        glDepthMask(GL_FALSE);
        glEnable(GL_CULL_FACE); // one surface on the way in
        for (const part& one : parts_)
            if (one.paint.alpha < 1) draw_part(one);
        glDisable(GL_CULL_FACE);
        glDepthMask(GL_TRUE);
        glDisable(GL_LIGHTING);
        glDisable(GL_DEPTH_TEST);
        glDisable(GL_SCISSOR_TEST);
    }

    /// Turns a drag in the view into events: of the needle where it is near, which advances, or enters elsewhere with Shift, else
    /// of the probe, which slides, or turns with Shift.
    void drag(const shown_frame& frame, worker& scanner, vec2 mouse, vec2 moved, bool begins, bool turns) {
        const vec2 tip = pixel(frame.needle.point({0, 0, 0})), end = pixel(frame.needle.point({0, 0, -80_mm}));
        if (begins) {
            const vec2 shaft = end - tip;
            const float along = clamp(dot(mouse - tip, shaft) / max(dot(shaft, shaft), 1), 0, 1);
            holds_needle_ = length(mouse - tip - along * shaft) < 12 &&
                            length(mouse - pixel(frame.probe.point({0, 0, -15_mm}))) > 40;
        }
        const float metres = 0.8F * distance / static_cast<float>(height_); // of a pixel, at the target
        const float x = moved.x * metres / 1_mm, y = moved.y * metres / 1_mm / max(std::fabs(std::sin(pitch)), 0.3F);
        const vec2 on_skin{x * std::cos(yaw) + y * std::sin(yaw), y * std::cos(yaw) - x * std::sin(yaw)}; // mm
        if (begins) entry_ = frame.needle_entry / 1_mm;
        if (holds_needle_ && turns) {
            entry_ += on_skin;
            scanner.push({"entry", {entry_.x, entry_.y}});
        } else if (holds_needle_) {
            const vec2 shaft = (tip - end) / 80.0F; // pixels of a millimetre
            scanner.push({"advance", {dot(moved, shaft) / max(dot(shaft, shaft), 0.1F)}});
        } else if (turns) {
            scanner.push({"rock", {0.3F * moved.x}});
            scanner.push({"tilt", {0.3F * moved.y}});
        } else {
            scanner.push({"slide", {on_skin.x, on_skin.y}});
        }
    }

  private:
    struct colour {
        float red, green, blue, alpha;
    };
    struct part {
        GLuint list;
        colour paint;
        bool is_cut;
    };

    static void draw_part(const part& one) {
        glColor4f(one.paint.red, one.paint.green, one.paint.blue, one.paint.alpha);
        glCallList(one.list);
    }

    static void draw_mesh(const mesh& surface, const pose& at) {
        glBegin(GL_TRIANGLES);
        for (const uvec3& face : surface.faces) {
            const vec3 a = at.point(surface.positions[face.x]), b = at.point(surface.positions[face.y]),
                       c = at.point(surface.positions[face.z]), normal = cross(b - a, c - a);
            glNormal3f(normal.x, normal.y, normal.z);
            for (const vec3& corner : {a, b, c}) glVertex3f(corner.x, corner.y, corner.z);
        }
        glEnd();
    }

    static void draw_slice(const shown_frame& frame, GLuint picture) {
        constexpr float s[] = {0, 1, 1, 0}, t[] = {0, 0, 1, 1};
        glEnable(GL_TEXTURE_2D);
        glBindTexture(GL_TEXTURE_2D, picture);
        glColor4f(1, 1, 1, 0.92F);
        glAlphaFunc(GL_GREATER, 0.5F); // beside a sector there is nothing
        glEnable(GL_ALPHA_TEST);
        glBegin(GL_QUADS);
        for (int i = 0; i < 4; ++i) {
            glTexCoord2f(s[i], t[i]);
            glVertex3f(frame.corners[i].x, frame.corners[i].y, frame.corners[i].z);
        }
        glEnd();
        glDisable(GL_ALPHA_TEST);
        glDisable(GL_TEXTURE_2D);
        glColor4f(0.4F, 0.8F, 1, 1);
        glBegin(GL_LINE_LOOP);
        for (const vec3& point : frame.outline) glVertex3f(point.x, point.y, point.z);
        glEnd();
    }

    // What is cut ends at the plane of the picture, on the side of the camera.
    void place_cut(const shown_frame& frame) const {
        const vec3& corner = frame.corners[0];
        vec3 behind = cross(frame.corners[1] - corner, frame.corners[3] - corner);
        if (dot(behind, camera().from - corner) > 0) behind = -behind;
        const double plane[] = {behind.x, behind.y, behind.z, -dot(behind, corner)};
        glClipPlane(GL_CLIP_PLANE0, plane);
    }

    struct axes {
        vec3 from, right, up, back;
    };
    axes camera() const {
        const vec3 from = target + distance * vec3{std::cos(pitch) * std::sin(yaw), std::cos(pitch) * std::cos(yaw),
                                                   -std::sin(pitch)};
        const vec3 back = normalize(from - target), right = normalize(cross(vec3{0, 0, -1}, back));
        return {from, right, cross(back, right), back};
    }
    // Where a point of the world is in the window.
    vec2 pixel(vec3 point) const {
        const axes view = camera();
        const vec3 away = point - view.from;
        const float scale = static_cast<float>(height_) / (0.8F * max(-dot(away, view.back), 1_mm));
        return {static_cast<float>(left_) + 0.5F * static_cast<float>(width_) + scale * dot(away, view.right),
                0.5F * static_cast<float>(height_) - scale * dot(away, view.up)};
    }

    // From +y, with depth down in the window: x to the right, as in the picture.
    void place_camera(double aspect) const {
        glMatrixMode(GL_PROJECTION);
        glLoadIdentity();
        constexpr double near = 0.005, far = 20, half = 0.4 * near;
        glFrustum(-half * aspect, half * aspect, -half, half, near, far);
        const auto [from, right, up, back] = camera();
        const float view[] = {right.x, up.x, back.x, 0, right.y,           up.y,           back.y,           0,
                              right.z, up.z, back.z, 0, -dot(right, from), -dot(up, from), -dot(back, from), 1};
        glMatrixMode(GL_MODELVIEW);
        glLoadIdentity();
        const float light[] = {0.3F, 0.6F, 1, 0};
        glLightfv(GL_LIGHT0, GL_POSITION, light);
        glLoadMatrixf(view);
    }

    std::vector<part> parts_{};
    float all_ = 0;                         // distance from which all of the anatomy is seen
    int left_ = 0, width_ = 1, height_ = 1; // of the part of the window
    bool holds_needle_ = false;
    vec2 entry_{0, 0}; // of the needle that is dragged, mm
};

} // namespace live

#endif
