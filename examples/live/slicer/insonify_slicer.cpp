/// A live ultrasound scanner for 3D Slicer, PLUS and every other client of OpenIGTLink: see README.md, or
/// `insonify_slicer --help`.
#include "../../simulate_options.hpp"
#include "../obj.hpp"
#include "../recording.hpp"
#include "commands.hpp"
#include "sequence_file.hpp"
#include "server.hpp"
#include <csignal>
#include <cstdio>
#include <iostream>

namespace {

using namespace insonify;

struct options {
    std::uint16_t port = 18944;
    float fps = 30;
    std::string replay{}, record{}, obj{}, background = "air";
    std::uint32_t frames = 0;
    float unit = 1;
};

void add_options(CLI::App& app, options& into) {
    using units = std::map<std::string, float>;
    const auto length = CLI::AsNumberWithUnit(units{{"um", 1e-3F}, {"mm", 1}, {"cm", 10}, {"m", 1000}});
    const auto add = [&](const char* name, auto& value, const char* shown, const char* help) {
        return app.add_option(name, value, help)->type_name(shown)->option_text(shown);
    };
    app.description(
        "A simulated ultrasound scanner that sends its pictures by OpenIGTLink, as PLUS does, to 3D Slicer and "
        "others.\n"
        "Start it without options, then add a client connector to localhost, port 18944, in Slicer's OpenIGTLinkIF.");
    app.get_formatter()->column_width(28);
    add("--port", into.port, "NUMBER", "TCP port; 0 chooses a free one (18944)");
    add("--fps", into.fps, "NUMBER", "pictures a second (30)")->check(positive_number());
    add("--obj", into.obj, "FILE",
        "anatomy: Wavefront OBJ, whose materials name the tissues (a phantom of a nerve block)");
    add("--unit", into.unit, "LENGTH", "length of one unit of that file (1mm)")
        ->transform(length)
        ->check(positive_number());
    add("--background", into.background, "TISSUE", "medium around its objects (air)");
    add("--replay", into.replay, "FILE", "plays a recorded session, a text file of events, such as nerve_block.txt");
    add("--record", into.record, "FILE", "writes the pictures and poses to a sequence of PLUS, FILE.igs.mha");
    add("--frames", into.frames, "COUNT", "ends after so many pictures (0: never)");
    app.footer("Knobs are turned by COMMAND or STRING messages, such as \"gain 6\". All events:\n" +
               live::session::help());
}

live::session make_session(const options& chosen) {
    if (chosen.obj.empty()) return live::session{};
    const std::optional<medium> background = tissue::find(chosen.background);
    if (!background) throw usage_error{"--background: there is no tissue '" + chosen.background + "'"};
    return live::session_of_obj(chosen.obj, chosen.unit * 1_mm, *background);
}

// Does what a client asks for and answers.
void serve(live::session& session, slicer::server& server, const slicer::request& one) {
    if (const auto* const asked = std::get_if<slicer::command>(&one.asked)) {
        server.answer(one, slicer::pack_outcome(one.head, *asked, slicer::apply(session, *asked)));
        return;
    }
    const std::optional<live::event> event = slicer::pose_event(one.head.device, std::get<pose>(one.asked));
    if (event) session.apply(*event);
    server.answer(one, event ? slicer::bytes{}
                             : slicer::pack_status(igtl::StatusMessage::STATUS_NOT_FOUND,
                                                   one.head.device + " moves nothing; ProbeToReference and "
                                                                     "NeedleTipToReference do"));
}

slicer::frame_messages pack(const live::session& session, double time) {
    slicer::bytes transforms = slicer::pack_transform("ProbeToReference", session.probe_pose(), time);
    const slicer::bytes needle = slicer::pack_transform("NeedleTipToReference", session.needle.at(), time);
    transforms.insert(transforms.end(), needle.begin(), needle.end());
    return {std::make_shared<const slicer::bytes>(std::move(transforms)),
            std::make_shared<const slicer::bytes>(slicer::pack_image(
                "Image_Reference", session.machine.picture(), session.machine.map(), session.machine.at(), time))};
}

volatile std::sig_atomic_t stopped = 0;

void run(const options& chosen) {
    const std::vector<live::step> steps =
        chosen.replay.empty() ? std::vector<live::step>{} : live::load_recording(chosen.replay);
    std::optional<slicer::sequence_file> record;
    if (!chosen.record.empty()) record.emplace(chosen.record);
    live::session session = make_session(chosen);
    session.apply({"lines", {128}}); // 30 pictures a second on two cores
    session.apply({"planes", {3}});
    slicer::server server{chosen.port};
    std::printf(
        "Listening on port %u, %g pictures a second; Ctrl-C ends.\n"
        "3D Slicer: module OpenIGTLinkIF > Connectors > +; Type: Client, Hostname: localhost, Port: %u; tick Active.\n"
        "The volume Image_Reference and the transforms ProbeToReference and NeedleTipToReference appear.\n",
        server.port(), static_cast<double>(chosen.fps), server.port());
    std::fflush(stdout);

    const auto period =
        std::chrono::duration_cast<slicer::steady::duration>(std::chrono::duration<float>{1 / chosen.fps});
    slicer::steady::time_point next = slicer::steady::now();
    std::uint32_t drawn = 0;
    // Draws a picture when its time has come and somebody looks; false at the end.
    const auto draw = [&](live::session& live) {
        do {
            std::this_thread::sleep_until(next);
            next = std::max(next + period, slicer::steady::now());
            if (stopped != 0 || (chosen.frames != 0 && drawn == chosen.frames)) return false;
            for (const slicer::request& one : server.take()) serve(live, server, one);
        } while (server.clients() == 0 && chosen.frames == 0 && !record);
        const double time = slicer::now();
        live.frame(exec::par_unseq);
        ++drawn;
        const scanner<linear_array>& machine = live.machine;
        server.publish(pack(live, time), machine.frozen() ? "frozen" : "running");
        if (record && !machine.frozen())
            record->add(machine.picture(), machine.map(), machine.at(), live.needle.at(), time);
        return true;
    };
    live::play(steps, session, draw);
    while (draw(session)) {
    }
    if (record) std::printf("%u pictures are in %s\n", record->total(), chosen.record.c_str());
}

} // namespace

int main(int argc, char** argv) {
    options chosen;
    CLI::App app;
    try {
        add_options(app, chosen);
        app.parse(argc, argv);
        for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stopped = 1; });
        run(chosen);
        return 0;
    } catch (const CLI::Success& help) {
        return app.exit(help);
    } catch (const std::exception& fault) {
        std::cerr << "insonify_slicer: " << fault.what() << '\n';
        return 2;
    }
}
