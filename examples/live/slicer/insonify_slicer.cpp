/// A live ultrasound scanner for 3D Slicer, PLUS and every other client of OpenIGTLink: see README.md, or
/// `insonify_slicer --help`.
#include "../loop.hpp"
#include "../options.hpp"
#include "commands.hpp"
#include "sequence_file.hpp"
#include "server.hpp"
#include <csignal>
#include <cstdio>

namespace {

using namespace insonify;

struct options {
    std::uint16_t port = 18944;
    double fps = 30;
    std::string replay{}, record{};
    std::uint64_t frames = 0; // 0: never ends
    live::anatomy_options body{};
};

void add_options(CLI::App& app, options& into) {
    using namespace command_line;
    app.description(
        "A simulated ultrasound scanner that sends its pictures by OpenIGTLink, as PLUS does, to 3D Slicer and "
        "others.\n"
        "Start it without options, then add a client connector to localhost, port 18944, in Slicer's OpenIGTLinkIF.");
    add_whole_number(app, "--port", into.port, "NUMBER", "TCP port; 0 chooses a free one", 0, 65535);
    add(app, "--fps", into.fps, "NUMBER", "pictures a second, 1 to 120 (30); a recorded session has its own")
        ->check(number(1, 120));
    live::add_anatomy_options(app, into.body);
    add(app, "--replay", into.replay, "FILE",
        "plays a recorded session, a text file of events, such as nerve_block.txt")
        ->check(name());
    add(app, "--record", into.record, "FILE", "writes the pictures and poses to a sequence of PLUS, FILE.igs.mha")
        ->check(name());
    add_whole_number(app, "--frames", into.frames, "COUNT", "ends after so many pictures", 1, live::max_frames);
    app.footer("Knobs are turned by COMMAND or STRING messages, such as \"gain 6\". All events:\n" +
               live::session::help());
}

// Does what a client asks for and answers.
void serve(live::session& session, slicer::server& server, const slicer::request& one) {
    if (const auto* const asked = std::get_if<slicer::command>(&one.asked)) {
        server.answer(one, slicer::pack_outcome(one.head, *asked, slicer::apply(session, *asked)));
        return;
    }
    const std::optional<live::event> event = slicer::pose_event(one.head.device, std::get<pose>(one.asked));
    if (!event)
        return server.answer(one, slicer::pack_status(igtl::StatusMessage::STATUS_NOT_FOUND,
                                                      one.head.device + " moves nothing; ProbeToReference and "
                                                                        "NeedleTipToReference do"));
    try {
        live::check_range(*event);
        session.apply(*event);
    } catch (const std::invalid_argument& fault) {
        server.answer(
            one, slicer::pack_status(igtl::StatusMessage::STATUS_CONFIG_ERROR, one.head.device + ": " + fault.what()));
    }
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

// What the server does in `live::run_loop`.
class program {
  public:
    explicit program(const options& chosen) : chosen_{chosen} {
        if (!chosen.record.empty()) record_.emplace(chosen.record);
    }

    void listen() {
        server_.emplace(chosen_.port);
        std::printf("Listening on port %u, %g pictures a second; Ctrl-C ends.\n"
                    "3D Slicer: module OpenIGTLinkIF > Connectors > +; Type: Client, Hostname: localhost, Port: %u; "
                    "tick Active.\n"
                    "The volume Image_Reference and the transforms ProbeToReference and NeedleTipToReference appear.\n",
                    server_->port(), chosen_.fps, server_->port());
        std::fflush(stdout);
    }
    void print_recorded() const {
        if (record_) std::printf("%u pictures are in %s\n", record_->total(), chosen_.record.c_str());
    }

    bool wait(live::steady::time_point until) const {
        while (!ends() && live::steady::now() < until) // a signal does not end the sleep of a thread
            std::this_thread::sleep_until(std::min(until, live::steady::now() + std::chrono::milliseconds{50}));
        return !ends();
    }
    // What is left after `input_time` is done before the next picture.
    bool take(live::session& with) {
        constexpr auto input_time = std::chrono::milliseconds{10};
        const live::steady::time_point begin = live::steady::now();
        while (stopped == 0 && live::steady::now() - begin < input_time) {
            const std::optional<slicer::request> one = server_->take();
            if (!one) break;
            serve(with, *server_, *one);
        }
        return server_->clients() > 0 || chosen_.frames != 0 || record_;
    }
    static bool stops_replay() { return false; }
    static void refuse(const std::exception& fault) { std::fprintf(stderr, "--replay: %s\n", fault.what()); }
    void draw(live::session& with) {
        const double time = slicer::now();
        with.frame(exec::par_unseq);
        ++drawn_;
        const scanner<live::array_probe>& machine = with.machine;
        server_->publish(pack(with, time), machine.frozen() ? "frozen" : "running");
        if (record_ && !machine.frozen())
            record_->add(machine.picture(), machine.map(), machine.at(), with.needle.at(), time);
    }

  private:
    bool ends() const { return stopped != 0 || (chosen_.frames != 0 && drawn_ == chosen_.frames); }

    const options& chosen_;
    std::optional<slicer::sequence_file> record_{};
    std::optional<slicer::server> server_{};
    std::uint64_t drawn_ = 0;
};

int run(const options& chosen) {
    for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, [](int) { stopped = 1; });
    std::optional<live::recording> played;
    if (!chosen.replay.empty()) played = live::load_recording(chosen.replay);
    program running{chosen};
    live::loaded_anatomy examined = live::load_body(live::choice_of(chosen.body), played ? &*played : nullptr);
    std::printf("%s\n", live::describe(examined).c_str());
    live::session session = live::begin_session(std::move(examined));
    session.apply({"lines", {128}}); // 30 pictures a second on two cores
    session.apply({"planes", {3}});
    running.listen();
    std::optional<live::player> replay;
    if (played) replay.emplace(std::move(played->steps));
    live::run_loop(session, replay, chosen.fps, running);
    running.print_recorded();
    return 0;
}

} // namespace

int main(int count, char** arguments) {
    options chosen;
    return command_line::run(
        "insonify_slicer", count, arguments, [&](CLI::App& app) { add_options(app, chosen); },
        [&] { return run(chosen); });
}
