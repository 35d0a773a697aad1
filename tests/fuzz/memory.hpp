#ifndef INSONIFY_TESTS_FUZZ_MEMORY_HPP
#define INSONIFY_TESTS_FUZZ_MEMORY_HPP

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <malloc.h>
#include <new>

/// Counts what `new` has given out, and refuses what is too much at once. For one file of a program.
namespace fuzz {

inline std::size_t max_allocation = ~std::size_t{0};

inline std::atomic<std::size_t> live_bytes{0}, peak_bytes{0};

/// While it lives, nothing larger is given out.
class allowance {
  public:
    explicit allowance(std::size_t bytes) { max_allocation = bytes; }
    allowance(const allowance&) = delete;
    allowance& operator=(const allowance&) = delete;
    ~allowance() { max_allocation = ~std::size_t{0}; }
};

/// Starts a measurement: `peak() - start` is then what was taken at most.
inline std::size_t start_measuring() {
    peak_bytes = live_bytes.load();
    return live_bytes;
}

inline void* take(std::size_t size, std::size_t alignment) {
    if (size > max_allocation) throw std::bad_alloc{};
    void* memory = alignment == 0 ? std::malloc(size == 0 ? 1 : size)
                                  : std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
    if (memory == nullptr) throw std::bad_alloc{};
    const std::size_t now = live_bytes += malloc_usable_size(memory);
    if (now > peak_bytes) peak_bytes = now;
    return memory;
}
inline void give_back(void* memory) noexcept {
    if (memory != nullptr) live_bytes -= malloc_usable_size(memory);
    std::free(memory);
}

} // namespace fuzz

void* operator new(std::size_t size) { return fuzz::take(size, 0); }
void* operator new(std::size_t size, std::align_val_t alignment) {
    return fuzz::take(size, static_cast<std::size_t>(alignment));
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    try {
        return fuzz::take(size, 0);
    } catch (const std::bad_alloc&) {
        return nullptr;
    }
}
void operator delete(void* memory, const std::nothrow_t&) noexcept { fuzz::give_back(memory); }
void operator delete(void* memory) noexcept { fuzz::give_back(memory); }
void operator delete(void* memory, std::size_t) noexcept { fuzz::give_back(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { fuzz::give_back(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { fuzz::give_back(memory); }

#endif
