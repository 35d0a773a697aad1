/// The tests of the live programs: live_tests NAME [FILE]
#include <cstdio>
#include <exception>
#include <string>

namespace anatomy_test {
int run(const std::string& limb);
}
namespace cases_test {
int run();
}
namespace events_test {
int run();
}
namespace loop_test {
int run();
}
namespace nerve_block_test {
int run(const std::string& recording);
}
namespace recorder_test {
int run();
}

int main(int count, char** arguments) {
    const std::string name = count > 1 ? arguments[1] : "", file = count > 2 ? arguments[2] : "";
    try {
        if (name == "anatomy") return anatomy_test::run(file);
        if (name == "cases") return cases_test::run();
        if (name == "events") return events_test::run();
        if (name == "loop") return loop_test::run();
        if (name == "nerve_block") return nerve_block_test::run(file);
        if (name == "recorder") return recorder_test::run();
        std::printf("live_tests anatomy | cases | events | loop | nerve_block | recorder [FILE]\n");
    } catch (const std::exception& fault) {
        std::printf("%s\n", fault.what());
    }
    return 1;
}
