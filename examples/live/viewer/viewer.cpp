/// A scanner on the desktop: viewer --help
#include "../options.hpp"
#include "knobs.hpp"
#include "view3d.hpp"
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl2.h>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <imgui.h>
#include <limits>
#include <optional>

namespace {

using namespace insonify;

struct options {
    std::string replay{}, record{}, screenshot{};
    live::anatomy_options body{};
    std::uint64_t frames = 0; // 0: until the window is closed
};

volatile std::sig_atomic_t stopped = 0;

// Keys and mouse that move the probe, the needle and the camera.
void steer(live::worker& scanner, live::view3d& space, const live::shown_frame& frame, float left_edge) {
    ImGuiIO& io = ImGui::GetIO();
    const float step = 30 * io.DeltaTime; // mm or degrees
    if (!io.WantCaptureKeyboard) {
        const auto both = [&](int less, int more) {
            return step * static_cast<float>(ImGui::IsKeyDown(more) - ImGui::IsKeyDown(less));
        };
        const float x = both(GLFW_KEY_LEFT, GLFW_KEY_RIGHT), y = both(GLFW_KEY_UP, GLFW_KEY_DOWN);
        if (x != 0 || y != 0) scanner.push({"slide", {x, y}});
        const std::pair<const char*, float> turns[] = {{"tilt", both(GLFW_KEY_S, GLFW_KEY_W)},
                                                       {"rock", both(GLFW_KEY_A, GLFW_KEY_D)},
                                                       {"rotate", both(GLFW_KEY_Q, GLFW_KEY_E)},
                                                       {"press", 0.2F * both(GLFW_KEY_R, GLFW_KEY_F)},
                                                       {"advance", 0.5F * both(GLFW_KEY_PAGE_UP, GLFW_KEY_PAGE_DOWN)}};
        for (const auto& [name, amount] : turns)
            if (amount != 0) scanner.push({name, {amount}});
        if (ImGui::IsKeyPressed(GLFW_KEY_C, false)) space.cuts = !space.cuts;
        if (ImGui::IsKeyPressed(GLFW_KEY_SPACE, false)) scanner.push({frame.frozen ? "unfreeze" : "freeze", {}});
    }
    if (io.WantCaptureMouse || io.MousePos.x < left_edge) return;
    space.zoom(1 - 0.1F * io.MouseWheel);
    if (ImGui::IsMouseDown(ImGuiMouseButton_Right)) {
        space.yaw -= 0.01F * io.MouseDelta.x;
        space.pitch = std::clamp(space.pitch + 0.01F * io.MouseDelta.y, -1.5F, 1.5F);
    }
    const bool begins = ImGui::IsMouseClicked(ImGuiMouseButton_Left);
    if (begins || (ImGui::IsMouseDown(ImGuiMouseButton_Left) && (io.MouseDelta.x != 0 || io.MouseDelta.y != 0)))
        space.drag(frame, scanner, {io.MousePos.x, io.MousePos.y}, {io.MouseDelta.x, io.MouseDelta.y}, begins,
                   io.KeyShift);
}

// What a user needs first. Closed by its button.
void show_hint(bool& open, float left) {
    if (!open) return;
    ImGui::SetNextWindowPos({left + 12, 12});
    ImGui::Begin("First steps", &open, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoMove);
    ImGui::TextUnformatted("Probe: drag it here, or arrow keys; with Shift: tilt, rock\n"
                           "W S tilt, A D rock, Q E rotate, F R press and lift\n"
                           "Needle: drag it along its shaft, or Page Down, Page Up; with Shift: its entry\n"
                           "Space freezes. Click twice on the picture to measure\n"
                           "Right drag turns this view; C shows all of the anatomy, or cuts it\n"
                           "Knobs explain themselves");
    ImGui::End();
}

void write_screenshot(const std::string& path, int width, int height) {
    std::vector<unsigned char> bytes(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
    colour_image seen{{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)}};
    for (std::uint32_t y = 0; y < seen.size.y; ++y)
        for (std::uint32_t x = 0; x < seen.size.x; ++x)
            for (std::uint32_t i = 0; i < 3; ++i)
                seen(x, seen.size.y - 1 - y)[static_cast<int>(i)] =
                    static_cast<float>(bytes[3 * (std::size_t{y} * seen.size.x + x) + i]) / 255;
    write_png(path, seen);
}

// The window.
class application {
  public:
    explicit application(const options& asked) : asked_{asked} {
        if (glfwInit() == 0) throw std::runtime_error{"there is no display; use xvfb-run"};
        glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 2);
        glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 1);
        window_ = glfwCreateWindow(1280, 800, "insonify", nullptr, nullptr);
        if (window_ == nullptr) throw std::runtime_error{"OpenGL 2.1 is not available"};
        glfwMakeContextCurrent(window_);
        glfwSwapInterval(asked.screenshot.empty() ? 1 : 0);
        ImGui::CreateContext();
        ImGui::GetIO().IniFilename = nullptr;
        ImGui::GetStyle().WindowRounding = 0;
        ImGui_ImplGlfw_InitForOpenGL(window_, true);
        ImGui_ImplOpenGL2_Init();
        glGenTextures(2, textures_);
    }
    application(const application&) = delete;
    application& operator=(const application&) = delete;
    ~application() {
        ImGui_ImplOpenGL2_Shutdown();
        ImGui_ImplGlfw_Shutdown();
        ImGui::DestroyContext();
        glfwTerminate();
    }

    void run() {
        std::optional<live::recording> played;
        if (!asked_.replay.empty()) played = live::load_recording(asked_.replay);
        live::loaded_anatomy examined = live::load_body(live::choice_of(asked_.body), played ? &*played : nullptr);
        std::printf("%s\n", live::describe(examined).c_str());
        std::fflush(stdout);
        std::ofstream file;
        std::optional<live::recorder> record;
        if (!asked_.record.empty()) {
            file.open(asked_.record);
            if (!examined.file.file.empty())
                file << live::anatomy_line({examined.file, examined.content},
                                           std::filesystem::path{asked_.record}.parent_path())
                     << std::endl;
            if (!examined.given.region.empty()) file << live::parameters_line(examined.given) << std::endl;
            if (!file) throw std::runtime_error{"--record: " + asked_.record + " cannot be written"};
            record.emplace(file);
        }
        live::session session = live::begin_session(std::move(examined), record ? &*record : nullptr);
        for (const live::event& start : {live::event{"lines", {128}}, {"planes", {3}}, {"width", {420}}})
            session.apply(start);
        live::view3d space;
        std::optional<live::player> replay;
        if (played) replay.emplace(std::move(played->steps));
        show(session, std::move(replay), space);
        record.reset(); // writes what is left
        if (!asked_.record.empty() && !file.flush())
            throw std::runtime_error{"--record: " + asked_.record + " is not whole: the disk may be full"};
    }

  private:
    // Until the window is closed.
    void show(live::session& session, std::optional<live::player> replay, live::view3d& space) {
        constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();
        live::worker scanner{session, std::move(replay), asked_.frames == 0 ? unlimited : asked_.frames};
        live::pacer pace;
        int settled = 0; // windows take two rounds to find their sizes
        while (glfwWindowShouldClose(window_) == 0 && stopped == 0 && settled < 4) {
            pace.turn(1.0 / 60);
            glfwPollEvents();
            if (scanner.newer(frame_)) {
                if (anatomy_ != frame_.anatomy) space.show(*(anatomy_ = frame_.anatomy), frame_.probe.translation);
                live::upload(textures_[0], frame_.screen, frame_.seen);
                if (frame_.strip.size.x > 0) live::upload(textures_[1], frame_.strip);
                if (knobs_.saves_sequence) write_png(numbered("frame_"), frame_.screen);
            }
            draw(scanner, space);
            if (asked_.frames != 0 && frame_.count >= asked_.frames && ++settled == 4 && !asked_.screenshot.empty())
                write_screenshot(asked_.screenshot, width_, height_);
            if (knobs_.wants_screenshot) write_screenshot(numbered("insonify_"), width_, height_);
            glfwSwapBuffers(window_);
            std::this_thread::sleep_until(pace.due());
        }
    }

    std::string numbered(const char* name) const {
        const std::string digits = std::to_string(frame_.count);
        return name + std::string(digits.size() < 6 ? 6 - digits.size() : 0, '0') + digits + ".png";
    }

    void draw(live::worker& scanner, live::view3d& space) {
        ImGui_ImplOpenGL2_NewFrame();
        ImGui_ImplGlfw_NewFrame();
        ImGui::NewFrame();
        glfwGetFramebufferSize(window_, &width_, &height_);
        const float left = 0.55F * static_cast<float>(width_), tall = static_cast<float>(height_), knobs = 276;
        constexpr auto fixed = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoCollapse |
                               ImGuiWindowFlags_NoTitleBar;
        ImGui::SetNextWindowPos({0, 0});
        ImGui::SetNextWindowSize({left, tall - knobs});
        ImGui::Begin("Ultrasound", nullptr, fixed);
        if (frame_.count > 0) picture_.show(frame_, textures_[0], textures_[1], scanner);
        ImGui::End();
        ImGui::SetNextWindowPos({0, tall - knobs});
        ImGui::SetNextWindowSize({left, knobs});
        ImGui::Begin("Controls", nullptr, fixed);
        if (frame_.count > 0) knobs_.show(frame_, scanner, picture_);
        if (const std::string fault = scanner.fault(); !fault.empty())
            ImGui::TextColored({1, 0.5F, 0.4F, 1}, "%s", fault.c_str());
        ImGui::End();
        show_hint(shows_hint_, left);
        if (frame_.count > 0) steer(scanner, space, frame_, left);
        ImGui::Render();
        if (frame_.count > 0)
            space.draw(static_cast<int>(left), 0, width_ - static_cast<int>(left), height_, frame_, textures_[0]);
        glViewport(0, 0, width_, height_);
        ImGui_ImplOpenGL2_RenderDrawData(ImGui::GetDrawData());
    }

    const options& asked_;
    GLFWwindow* window_ = nullptr;
    GLuint textures_[2] = {}; // of the picture and the strip
    int width_ = 0, height_ = 0;
    bool shows_hint_ = true;
    live::shown_frame frame_{};
    std::shared_ptr<const live::shown_anatomy> anatomy_{}; // that the 3-D view has
    live::picture_panel picture_{};
    live::knob_panel knobs_{};
};

void add_options(CLI::App& app, options& into) {
    using namespace command_line;
    app.description("A simulated ultrasound scanner in a window.");
    live::add_anatomy_options(app, into.body);
    add(app, "--record", into.record, "FILE", "writes what is done to a text file")->check(name());
    add(app, "--replay", into.replay, "FILE", "plays such a file; then the scanner goes on")->check(name());
    CLI::Option* const frames =
        add_whole_number(app, "--frames", into.frames, "COUNT", "ends after so many frames", 1, live::max_frames);
    add(app, "--screenshot", into.screenshot, "PICTURE", "writes the window then to this PNG file")
        ->check(name())
        ->check(png_name())
        ->needs(frames);
    app.footer("Without --obj and --anatomy, a session is played on the anatomy that it was recorded with. Events of a "
               "session:\n" +
               live::session::help());
}

} // namespace

int main(int count, char** arguments) {
    options asked;
    return command_line::run(
        "viewer", count, arguments, [&](CLI::App& app) { add_options(app, asked); },
        [&] {
            for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stopped = 1; });
            application{asked}.run();
            return 0;
        });
}
