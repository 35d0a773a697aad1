#ifndef INSONIFY_TESTS_GUIDE_RUN_BLOCKS_HPP
#define INSONIFY_TESTS_GUIDE_RUN_BLOCKS_HPP

#include <cstddef>
#include <cstdio>
#include <exception>
#include <string>

/// A piece of code of a page, made a function.
struct guide_block {
    const char* where; ///< page and line
    void (*run)(int arguments, char** argument);
    const char* prints; ///< what the page says that it prints; null where it says nothing
};

/// What was printed since the last call.
inline std::string take_printed() {
    static const char* const name = "printed.txt";
    std::fflush(stdout);
    std::string text;
    if (std::FILE* file = std::fopen(name, "r")) {
        for (int c = std::fgetc(file); c != EOF; c = std::fgetc(file)) text.push_back(static_cast<char>(c));
        std::fclose(file);
    }
    if (std::freopen(name, "w", stdout) == nullptr) std::fputs("printed.txt cannot be written\n", stderr);
    return text;
}

/// Runs every block, in the order of the pages, and tells which did not do what its page says.
/// @return how many
template <std::size_t Count>
int run_blocks(const guide_block (&blocks)[Count], int arguments, char** argument) {
    int faults = 0;
    const auto fault = [&](const guide_block& block, const std::string& what) {
        std::fprintf(stderr, "%s: %s\n", block.where, what.c_str());
        ++faults;
    };
    take_printed();
    for (const guide_block& block : blocks) {
        try {
            block.run(arguments, argument);
        } catch (const std::exception& e) {
            fault(block, std::string{"threw: "} + e.what());
        }
        const std::string printed = take_printed();
        if (block.prints != nullptr && printed != block.prints)
            fault(block, "the page says that it prints\n" + std::string{block.prints} + "but it printed\n" + printed);
    }
    std::fprintf(stderr, "%zu blocks, %d faults\n", Count, faults);
    return faults;
}

#endif
