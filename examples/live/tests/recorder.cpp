/// What a recorder has written when its program crashes: all but the last second. live_tests recorder
#include "../recording.hpp"
#include <cstdio>

namespace recorder_test {
namespace {

struct contents {
    std::uint32_t frames = 0;
    std::vector<std::string> events{};
};

contents contents_of(const std::string& name) {
    contents all;
    for (const live::step& one : live::load_recording(name).steps) {
        all.frames += one.frames;
        if (one.what) all.events.push_back(live::event_line(*one.what));
    }
    return all;
}

} // namespace

int run() {
    const char* const name = "recorder.txt";
    std::ofstream file{name};
    bool holds = true;
    {
        live::recorder record{file};
        record.add({"depth", {35}});
        record.add_frame();
        record.add({"slide", {0.1F, -2}});
        for (int i = 0; i < 75; ++i) record.add_frame();
        const contents written = contents_of(name); // as after a crash
        std::printf("after a crash: %zu events and %u frames; expected 2, and 47 to 76\n", written.events.size(),
                    written.frames);
        holds = written.events == std::vector<std::string>{"depth 35", "slide 0.100000001 -2"} && written.frames >= 47;
    }
    const contents written = contents_of(name);
    std::printf("at the end: %u frames; expected 76\n", written.frames);
    return holds && written.events.size() == 2 && written.frames == 76 ? 0 : 1;
}

} // namespace recorder_test
