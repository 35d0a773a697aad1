#ifndef INSONIFY_EXAMPLES_LIVE_VIEWER_VIEW3D_HPP
#define INSONIFY_EXAMPLES_LIVE_VIEWER_VIEW3D_HPP

#include "worker.hpp"
#include <GLFW/glfw3.h>

namespace live {

/// The anatomy, the probe with its picture, and the needle, drawn by OpenGL 2.
class view3d {
  public:
    float yaw = -0.5F, pitch = 0.5F, distance = 130_mm; ///< of the camera, about `target`
    vec3 target{0, 0, 15_mm};

    /// @param body  drawn as it is now
    explicit view3d(const scene& body) {
        for (const object& one : body.objects()) {
            if (one.name == "needle" || one.name == "gel") continue;
            const colour paint = colour_of(body, one);
            const GLuint list = glGenLists(1);
            glNewList(list, GL_COMPILE);
            draw_mesh(one.surface, one.at);
            glEndList();
            parts_.push_back({list, paint});
        }
        std::stable_sort(parts_.begin(), parts_.end(),
                         [](const part& a, const part& b) { return a.paint.alpha > b.paint.alpha; });
    }

    /// Draws into a part of the window, in pixels from its lower left corner.
    void draw(int x, int y, int width, int height, const shown_frame& frame, GLuint picture) const {
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
        for (const part& one : parts_)
            if (one.paint.alpha == 1) draw_part(one);
        glColor4f(0.8F, 0.85F, 0.9F, 1);
        draw_mesh(make_needle(needle_diameter(frame.gauge), 80_mm, {.bevel = frame.bevel}), frame.needle);
        glColor4f(0.35F, 0.55F, 0.75F, 1);
        draw_mesh(make_box({-22_mm, -6_mm, -30_mm}, {22_mm, 6_mm, -0.5_mm}), frame.probe);
        glDisable(GL_LIGHTING);
        draw_slice(frame, picture);
        glEnable(GL_LIGHTING);
        glDepthMask(GL_FALSE);
        for (const part& one : parts_)
            if (one.paint.alpha < 1) draw_part(one);
        glDepthMask(GL_TRUE);
        glDisable(GL_LIGHTING);
        glDisable(GL_DEPTH_TEST);
        glDisable(GL_SCISSOR_TEST);
    }

  private:
    struct colour {
        float red, green, blue, alpha;
    };
    struct part {
        GLuint list;
        colour paint;
    };

    // Tissues as in an atlas; what is wider than 40 mm is a layer, and transparent.
    static colour colour_of(const scene& body, const object& one) {
        const aabb box = body.box(one.id);
        const auto named = [&](const char* word) { return one.name.find(word) != std::string::npos; };
        if (named("artery")) return {0.8F, 0.15F, 0.15F, 1};
        if (named("vein")) return {0.2F, 0.3F, 0.8F, 1};
        if (named("nerve") || named("fascicle") || named("epineurium")) return {0.95F, 0.85F, 0.3F, 1};
        if (named("bone")) return {0.92F, 0.9F, 0.82F, 1};
        if (box.upper.x - box.lower.x > 40_mm) return {0.9F, 0.65F, 0.55F, named("skin") ? 0.12F : 0.03F};
        return {0.7F, 0.5F, 0.45F, 1};
    }

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
        glBegin(GL_QUADS);
        for (int i = 0; i < 4; ++i) {
            glTexCoord2f(s[i], t[i]);
            glVertex3f(frame.corners[i].x, frame.corners[i].y, frame.corners[i].z);
        }
        glEnd();
        glDisable(GL_TEXTURE_2D);
        glColor4f(0.4F, 0.8F, 1, 1);
        glBegin(GL_LINE_LOOP);
        for (const vec3& corner : frame.corners) glVertex3f(corner.x, corner.y, corner.z);
        glEnd();
    }

    // From +y, with depth down in the window: x to the right, as in the picture.
    void place_camera(double aspect) const {
        glMatrixMode(GL_PROJECTION);
        glLoadIdentity();
        constexpr double near = 0.005, far = 2, half = 0.4 * near;
        glFrustum(-half * aspect, half * aspect, -half, half, near, far);
        const vec3 from = target + distance * vec3{std::cos(pitch) * std::sin(yaw), std::cos(pitch) * std::cos(yaw),
                                                   -std::sin(pitch)};
        const vec3 back = normalize(from - target), right = normalize(cross(vec3{0, 0, -1}, back)),
                   up = cross(back, right);
        const float view[] = {right.x, up.x, back.x, 0, right.y,           up.y,           back.y,           0,
                              right.z, up.z, back.z, 0, -dot(right, from), -dot(up, from), -dot(back, from), 1};
        glMatrixMode(GL_MODELVIEW);
        glLoadIdentity();
        const float light[] = {0.3F, 0.6F, 1, 0};
        glLightfv(GL_LIGHT0, GL_POSITION, light);
        glLoadMatrixf(view);
    }

    std::vector<part> parts_{};
};

} // namespace live

#endif
