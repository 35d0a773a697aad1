/// A scanner on the desktop: viewer [--replay FILE] [--screenshot PICTURE] [--frames N] [--help]
///
/// With --replay the events of a file are played; with --screenshot the window is written to a PNG file after N frames, and
/// the program ends.
#define INSONIFY_IMPLEMENTATION
#include "view3d.hpp"
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl2.h>
#include <fstream>
#include <imgui.h>

namespace {

using namespace insonify;

struct options {
    std::string replay{}, screenshot{};
    std::uint32_t frames = 1;
};

// A knob: an event with one number.
struct knob {
    const char* event;
    const char* title;
    float value, lowest, highest;
    const char* format;
    const char* tooltip;
};
struct knob_group {
    const char* title;
    std::vector<knob> knobs;
};

std::vector<knob_group> scanner_knobs() {
    return {{"Image",
             {{"gain", "Gain", 0, -30, 30, "%.0f dB", "Brightness of the whole picture"},
              {"dynamic_range", "Dynamic range", 60, 30, 90, "%.0f dB", "Levels from black to white: less is harder"},
              {"depth", "Depth", 40, 20, 80, "%.0f mm", "Of the lower edge"},
              {"focus", "Focus", 18, 5, 70, "%.0f mm", "Depth where the beam is sent to; the mark beside the picture"},
              {"frequency", "Frequency", 7.5F, 4, 12, "%.1f MHz", "Higher: finer, but less deep"}}},
            {"Smoothing",
             {{"compound", "Looks", 1, 1, 7, "%.0f", "Spatial compounding: looks at several angles are averaged"},
              {"persistence", "Persistence", 0, 0, 0.9F, "%.2f", "Weight of earlier pictures"}}},
            {"Quality",
             {{"lines", "Lines", 128, 64, 256, "%.0f", "Scan lines of a picture"},
              {"planes", "Planes", 3, 1, 7, "%.0f", "Of the slice's thickness; odd"}}},
            {"Needle",
             {{"gauge", "Gauge", 22, 18, 25, "%.0f", "Higher is thinner"},
              {"bevel", "Bevel", 15, 10, 60, "%.0f deg", "Angle of the tip"},
              {"steepness", "Steepness", 30, 5, 85, "%.0f deg", "Angle to the skin"},
              {"aside", "Aside", 0, -45, 45, "%.0f deg", "Out of the slice"}}}};
}

void show_knobs(std::vector<knob_group>& groups, live::worker& scanner, bool& frozen) {
    for (knob_group& group : groups) {
        if (!ImGui::CollapsingHeader(group.title, ImGuiTreeNodeFlags_DefaultOpen)) continue;
        for (knob& one : group.knobs) {
            if (ImGui::SliderFloat(one.title, &one.value, one.lowest, one.highest, one.format))
                scanner.push({one.event, {one.value}});
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", one.tooltip);
        }
    }
    if (ImGui::CollapsingHeader("Time gain")) {
        static float sliders[8] = {};
        for (int i = 0; i < 8; ++i) {
            ImGui::PushID(i);
            if (ImGui::SliderFloat("##", &sliders[i], -20, 20, "%.0f dB"))
                scanner.push({"slider", {static_cast<float>(i), sliders[i]}});
            if (ImGui::IsItemHovered()) ImGui::SetTooltip("Gain at the depth %d / 7", i);
            ImGui::PopID();
        }
    }
    if (ImGui::Button(frozen ? "Unfreeze" : "Freeze")) scanner.push({frozen ? "unfreeze" : "freeze", {}});
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Space. Gain and dynamic range still act on a frozen picture");
}

// The picture with its depth scale, gray bar and focus mark.
void show_picture(const live::shown_frame& frame, GLuint texture) {
    const ImVec2 origin = ImGui::GetCursorScreenPos(), room = ImGui::GetContentRegionAvail();
    const auto columns = static_cast<float>(frame.picture.size.x), rows = static_cast<float>(frame.picture.size.y);
    const float scale = std::min((room.x - 70) / columns, (room.y - 24) / rows), left = origin.x + 34;
    ImDrawList* const draw = ImGui::GetWindowDrawList();
    draw->AddImage(reinterpret_cast<ImTextureID>(static_cast<std::intptr_t>(texture)), {left, origin.y},
                   {left + columns * scale, origin.y + rows * scale});
    const auto grey = IM_COL32(200, 200, 200, 255);
    const auto y_of = [&](float depth) { return origin.y + (depth - frame.top) / frame.pitch.y * scale; };
    for (int mm = 0; static_cast<float>(mm) * 1_mm < frame.depth; mm += 5) {
        const float y = y_of(static_cast<float>(mm) * 1_mm);
        draw->AddLine({left - (mm % 10 == 0 ? 10.0F : 5.0F), y}, {left, y}, grey);
        if (mm % 10 == 0) draw->AddText({origin.x, y - 7}, grey, std::to_string(mm).c_str());
    }
    const float focus = y_of(frame.focus), right = left + columns * scale;
    draw->AddTriangleFilled({right + 2, focus}, {right + 10, focus - 5}, {right + 10, focus + 5},
                            IM_COL32(255, 200, 60, 255));
    draw->AddRectFilledMultiColor({right + 16, origin.y}, {right + 28, origin.y + rows * scale},
                                  IM_COL32(255, 255, 255, 255), IM_COL32(255, 255, 255, 255), IM_COL32(0, 0, 0, 255),
                                  IM_COL32(0, 0, 0, 255));
    ImGui::SetCursorScreenPos({left, origin.y + rows * scale + 4});
    ImGui::Text("%.1f frames/s   %.1f ms   %s", frame.seconds > 0 ? 1 / frame.seconds : 0.0, 1e3 * frame.seconds,
                frame.frozen ? "FROZEN" : "");
}

void upload(GLuint texture, const image& picture) {
    static std::vector<unsigned char> bytes;
    bytes.resize(3 * picture.pixels.size());
    for (std::size_t i = 0; i < bytes.size(); ++i)
        bytes[i] = static_cast<unsigned char>(255 * std::clamp(picture.pixels[i / 3], 0.0F, 1.0F) + 0.5F);
    glBindTexture(GL_TEXTURE_2D, texture);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB, static_cast<GLsizei>(picture.size.x), static_cast<GLsizei>(picture.size.y),
                 0, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
}

// Keys and mouse that move the probe, the needle and the camera.
void steer(live::worker& scanner, live::view3d& space, bool frozen, float left_edge) {
    ImGuiIO& io = ImGui::GetIO();
    const auto held = [](int key) { return ImGui::IsKeyDown(key); };
    const float step = 30 * io.DeltaTime; // mm or degrees
    if (!io.WantCaptureKeyboard) {
        const auto both = [&](int less, int more) { return step * static_cast<float>(held(more) - held(less)); };
        const float x = both(GLFW_KEY_LEFT, GLFW_KEY_RIGHT), y = both(GLFW_KEY_UP, GLFW_KEY_DOWN);
        if (x != 0 || y != 0) scanner.push({"slide", {x, y}});
        const std::pair<const char*, float> turns[] = {{"tilt", both(GLFW_KEY_S, GLFW_KEY_W)},
                                                       {"rock", both(GLFW_KEY_A, GLFW_KEY_D)},
                                                       {"rotate", both(GLFW_KEY_Q, GLFW_KEY_E)},
                                                       {"advance", both(GLFW_KEY_PAGE_UP, GLFW_KEY_PAGE_DOWN)}};
        for (const auto& [name, amount] : turns)
            if (amount != 0) scanner.push({name, {amount}});
        if (ImGui::IsKeyPressed(GLFW_KEY_SPACE, false)) scanner.push({frozen ? "unfreeze" : "freeze", {}});
    }
    if (io.WantCaptureMouse || io.MousePos.x < left_edge) return;
    space.distance = std::clamp(space.distance * (1 - 0.1F * io.MouseWheel), 30_mm, 600_mm);
    if (ImGui::IsMouseDown(ImGuiMouseButton_Right)) {
        space.yaw -= 0.01F * io.MouseDelta.x;
        space.pitch = std::clamp(space.pitch + 0.01F * io.MouseDelta.y, -1.5F, 1.5F);
    }
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left) && (io.MouseDelta.x != 0 || io.MouseDelta.y != 0)) {
        const float mm = 0.2F;
        if (io.KeyShift) {
            scanner.push({"rock", {io.MouseDelta.x * mm}});
            scanner.push({"tilt", {io.MouseDelta.y * mm}});
        } else
            scanner.push({"slide", {io.MouseDelta.x * mm, io.MouseDelta.y * mm}});
    }
}

void write_screenshot(const std::string& path, int width, int height) {
    std::vector<unsigned char> bytes(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    image seen{{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)}};
    glReadPixels(0, 0, width, height, GL_GREEN, GL_UNSIGNED_BYTE, bytes.data());
    for (std::uint32_t y = 0; y < seen.size.y; ++y)
        for (std::uint32_t x = 0; x < seen.size.x; ++x)
            seen(x, seen.size.y - 1 - y) = static_cast<float>(bytes[std::size_t{y} * seen.size.x + x]) / 255;
    write_png(path, seen);
}

void run(const options& asked) {
    if (glfwInit() == 0) throw std::runtime_error{"viewer: there is no display; use xvfb-run"};
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 2);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 1);
    GLFWwindow* const window = glfwCreateWindow(1280, 760, "insonify", nullptr, nullptr);
    if (window == nullptr) throw std::runtime_error{"viewer: OpenGL 2.1 is not available"};
    glfwMakeContextCurrent(window);
    glfwSwapInterval(asked.screenshot.empty() ? 1 : 0);
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui_ImplGlfw_InitForOpenGL(window, true);
    ImGui_ImplOpenGL2_Init();
    GLuint texture = 0;
    glGenTextures(1, &texture);

    live::session session;
    session.apply({"lines", {128}});
    session.apply({"planes", {3}});
    session.apply({"width", {420}});
    live::view3d space{session.body};
    {
        live::worker scanner{session, !asked.replay.empty()};
        if (!asked.replay.empty()) {
            std::ifstream lines{asked.replay};
            if (!lines) throw std::runtime_error{"viewer: " + asked.replay + " cannot be opened"};
            std::uint32_t frames = 0; // a screenshot shows the last one that is asked for
            for (std::string line; std::getline(lines, line) && (asked.screenshot.empty() || frames < asked.frames);)
                if (const std::optional<live::event> next = live::parse_event(line)) {
                    frames += next->name == "frame" ? 1 : 0;
                    scanner.push(*next);
                }
        }
        std::vector<knob_group> knobs = scanner_knobs();
        live::shown_frame frame;
        int settled = 0; // windows take two rounds to find their sizes
        while (glfwWindowShouldClose(window) == 0 && settled < 3) {
            glfwPollEvents();
            if (scanner.newer(frame)) upload(texture, frame.picture);
            ImGui_ImplOpenGL2_NewFrame();
            ImGui_ImplGlfw_NewFrame();
            ImGui::NewFrame();
            int width = 0, height = 0;
            glfwGetFramebufferSize(window, &width, &height);
            const float left = 0.52F * static_cast<float>(width), tall = static_cast<float>(height);
            constexpr auto fixed = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse;
            ImGui::SetNextWindowPos({0, 0});
            ImGui::SetNextWindowSize({left, 0.66F * tall});
            ImGui::Begin("Ultrasound", nullptr, fixed);
            if (frame.count > 0) show_picture(frame, texture);
            ImGui::End();
            ImGui::SetNextWindowPos({0, 0.66F * tall});
            ImGui::SetNextWindowSize({0.6F * left, 0.34F * tall});
            ImGui::Begin("Controls", nullptr, fixed);
            show_knobs(knobs, scanner, frame.frozen);
            ImGui::End();
            ImGui::SetNextWindowPos({0.6F * left, 0.66F * tall});
            ImGui::SetNextWindowSize({0.4F * left, 0.34F * tall});
            ImGui::Begin("Keys", nullptr, fixed);
            ImGui::TextWrapped(
                "Arrows, or drag in 3-D: slide the probe\nW S tilt, A D rock, Q E rotate\nPage Down, Page Up: "
                "advance, withdraw the needle\nSpace: freeze\nRight drag: turn the view; wheel: zoom");
            ImGui::TextColored({1, 0.5F, 0.4F, 1}, "%s", scanner.fault().c_str());
            ImGui::End();
            if (asked.replay.empty()) steer(scanner, space, frame.frozen, left);
            ImGui::Render();
            space.draw(static_cast<int>(left), 0, width - static_cast<int>(left), height, frame, texture);
            glViewport(0, 0, width, height);
            ImGui_ImplOpenGL2_RenderDrawData(ImGui::GetDrawData());
            if (!asked.screenshot.empty() && frame.count >= asked.frames && ++settled == 3)
                write_screenshot(asked.screenshot, width, height);
            glfwSwapBuffers(window);
        }
    }
    ImGui_ImplOpenGL2_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwTerminate();
}

} // namespace

int main(int count, char** arguments) {
    try {
        options asked;
        for (int i = 1; i < count; i += 2) {
            const std::string name = arguments[i];
            if (name == "--help" || i + 1 == count) {
                std::printf("viewer [--replay FILE] [--screenshot PICTURE] [--frames N]; events in FILE:\n%s",
                            live::session::help().c_str());
                return name == "--help" ? 0 : 2;
            }
            const std::string value = arguments[i + 1];
            if (name == "--replay")
                asked.replay = value;
            else if (name == "--screenshot")
                asked.screenshot = value;
            else if (name == "--frames")
                asked.frames = static_cast<std::uint32_t>(std::max(std::stoi(value), 1));
            else
                throw std::runtime_error{"viewer: there is no option " + name};
        }
        run(asked);
        return 0;
    } catch (const std::exception& fault) {
        std::fprintf(stderr, "%s\n", fault.what());
        return 2;
    }
}
