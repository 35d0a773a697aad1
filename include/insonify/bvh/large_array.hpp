#ifndef INSONIFY_BVH_LARGE_ARRAY_HPP
#define INSONIFY_BVH_LARGE_ARRAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <cstddef>
#include <cstdint>
#include <new>
#include <vector>
#if defined(__linux__)
#include <sys/mman.h>
#endif
#if defined(__SANITIZE_ADDRESS__)
#define INSONIFY_ADDRESS_SANITIZER
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define INSONIFY_ADDRESS_SANITIZER
#endif
#endif
#if defined(INSONIFY_ADDRESS_SANITIZER)
#include <sanitizer/asan_interface.h>
#endif

namespace insonify::inline INSONIFY_ABI::detail {

/// Memory for arrays with random access, backed by huge pages where the system provides them: traversal of a large tree
/// otherwise has a TLB miss at nearly every node. New elements are uninitialised.
template <class T>
struct large_allocator {
    using value_type = T;

    large_allocator() = default;
    template <class Other>
    large_allocator(const large_allocator<Other>&) {}

    /// Aligned here because aligned allocations rarely reuse freed memory. What `operator new` returned is stored
    /// before the first element.
    T* allocate(std::size_t count) {
        constexpr std::size_t page = std::size_t{2} << 20U; // bytes; smaller arrays use ordinary pages
        constexpr std::size_t line = 64;                    // a cache line
        static_assert(alignof(T) <= line);
        const std::size_t bytes = count * sizeof(T), alignment = bytes >= page ? page : line;
        char* const memory = static_cast<char*>(::operator new(bytes + alignment));
        char* const first = memory + (alignment - reinterpret_cast<std::uintptr_t>(memory) % alignment);
        reinterpret_cast<char**>(first)[-1] = memory;
#if defined(MADV_HUGEPAGE)
        if (bytes >= page) madvise(first, bytes, MADV_HUGEPAGE); // a hint: its result does not matter
#endif
#if defined(INSONIFY_ADDRESS_SANITIZER) // the padding before and after the elements
        __asan_poison_memory_region(memory, static_cast<std::size_t>(first - memory) - sizeof memory);
        __asan_poison_memory_region(first + bytes, static_cast<std::size_t>(memory + alignment - first));
#endif
        return reinterpret_cast<T*>(first);
    }
    void deallocate(T* first, std::size_t) { ::operator delete(reinterpret_cast<char**>(first)[-1]); }

    void construct(T*) {} // leaves it uninitialised

    friend bool operator==(const large_allocator&, const large_allocator&) { return true; }
};

/// An array whose new elements are uninitialised: see `large_allocator`.
template <class T>
using large_array = std::vector<T, large_allocator<T>>;

} // namespace insonify::inline INSONIFY_ABI::detail
#undef INSONIFY_ADDRESS_SANITIZER

#include <insonify/core/restore_macros.hpp>

#endif
