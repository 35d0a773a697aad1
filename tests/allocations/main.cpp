#include <insonify/insonify.hpp>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <new>

// Counts what a clip allocates, frame by frame: nothing when it is shown again, and memory has grown to what it takes.
namespace {
std::atomic<long> allocations{0};
}

// Kept out of line: inlined, GCC would take malloc and delete, or new and free, for pairs that do not match.
[[gnu::noinline]] void* operator new(std::size_t size) {
    ++allocations;
    if (void* memory = std::malloc(size)) return memory;
    throw std::bad_alloc{};
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

int main() {
    using namespace insonify;
    scene body{tissue::muscle};
    body.add(make_sphere({-8_mm, 0, 15_mm}, 4_mm, 4), tissue::blood);
    const object_id bone = body.add(make_sphere({0, 0, 0}, 5_mm, 4), tissue::bone);
    body.build(exec::par);

    const linear_array probe{.lines = 128, .width = 40_mm, .frequency = 7.5_MHz};
    const b_mode_settings settings{.depth = 40_mm, .size = {256, 256}};
    const auto allocated_by = [&](const auto& policy) {
        b_mode_workspace<linear_array> own;
        const mesh rest = make_sphere({0, 0, 0}, 5_mm, 4);
        constexpr int frames = 8;
        long most = 0;
        for (int i = 0; i < 2 * frames; ++i) {
            const auto frame = static_cast<float>(i % frames);
            const long before = allocations;
            body.place(bone, {.translation = {8_mm, 0, 20_mm - 0.1_mm * frame}});
            const std::span<vec3> now = body.positions(bone);
            for (std::size_t k = 0; k < now.size(); ++k) now[k] = (1 - 0.01F * frame) * rest.positions[k];
            body.update(policy);
            b_mode(policy, body, probe, {.translation = {0, 0.05_mm * frame, 0}}, settings, physical{}, own);
            if (i >= frames) most = std::max(most, allocations - before);
        }
        return most;
    };
    const long sequenced = allocated_by(exec::seq), parallel = allocated_by(exec::par_unseq.threads(2));
    std::printf("allocations a frame: %ld with seq, %ld with par_unseq; expected 0\n", sequenced, parallel);
    return sequenced == 0 && parallel == 0 ? 0 : 1;
}
