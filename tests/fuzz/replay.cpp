// The fuzzing targets without libFuzzer: every input of a folder, then inputs made of them by chance, the same each time.
//     fuzz_<target> <folder> <number of inputs>
#include <insonify/core/random.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

using bytes = std::vector<std::uint8_t>;

class chance {
  public:
    explicit chance(std::uint64_t seed) : seed_{seed} {}
    std::size_t below(std::size_t n) { return n == 0 ? 0 : insonify::hash_bits(seed_, count_++) % n; }

  private:
    std::uint64_t seed_, count_ = 0;
};

bytes mutated(const std::vector<bytes>& seeds, std::uint64_t number) {
    chance any{number};
    bytes input = seeds[any.below(seeds.size())];
    for (std::size_t left = 1 + any.below(6); left > 0; --left) {
        const std::size_t at = any.below(input.size() + 1), end = at + any.below(input.size() + 1 - at);
        const auto place = [&](std::size_t i) { return input.begin() + static_cast<std::ptrdiff_t>(i); };
        switch (any.below(4)) {
        case 0: // a sign is another
            if (at < input.size()) input[at] = static_cast<std::uint8_t>(any.below(256));
            break;
        case 1: // some are missing
            input.erase(place(at), place(end));
            break;
        case 2: { // some come twice
            const bytes again(place(at), place(end));
            if (input.size() < 4096) input.insert(place(any.below(input.size() + 1)), again.begin(), again.end());
            break;
        }
        default: { // some are another input's
            const bytes& other = seeds[any.below(seeds.size())];
            for (std::size_t i = at; i < end && i < other.size(); ++i) input[i] = other[i];
        }
        }
    }
    return input;
}

} // namespace

int main(int count, char** words) {
    if (count != 3) {
        std::fprintf(stderr, "usage: %s <folder> <number of inputs>\n", words[0]);
        return 2;
    }
    std::vector<std::filesystem::path> paths;
    for (const auto& entry : std::filesystem::directory_iterator{words[1]}) paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    std::vector<bytes> seeds;
    for (const auto& path : paths) {
        std::ifstream file{path, std::ios::binary};
        seeds.emplace_back(std::istreambuf_iterator<char>{file}, std::istreambuf_iterator<char>{});
    }
    if (seeds.empty()) {
        std::fprintf(stderr, "%s: no inputs there\n", words[1]);
        return 2;
    }
    for (const bytes& seed : seeds) LLVMFuzzerTestOneInput(seed.data(), seed.size());
    const std::uint64_t largest = std::strtoull(words[2], nullptr, 10);
    for (std::uint64_t i = 0; i < largest; ++i) {
        const bytes input = mutated(seeds, i);
        LLVMFuzzerTestOneInput(input.data(), input.size());
    }
    std::printf("%zu inputs and %llu made of them\n", seeds.size(), static_cast<unsigned long long>(largest));
}
