#ifndef INSONIFY_BVH_LARGE_ARRAY_HPP
#define INSONIFY_BVH_LARGE_ARRAY_HPP

#include <insonify/core/config.hpp>
#include <cstddef>
#include <new>
#include <utility>
#include <vector>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace insonify::inline INSONIFY_ABI {

/// Memory for arrays that are walked all over: in large pages where the system gives them on request, since a ray through
/// a large tree otherwise waits for the address of nearly every node as well as for the node. New elements are left as
/// they come: write them before they are read, each thread its own.
template <class T>
struct large_allocator {
    using value_type = T;

    static constexpr std::size_t page = std::size_t{2} << 20U; ///< bytes; smaller arrays get ordinary memory

    large_allocator() = default;
    template <class U>
    large_allocator(const large_allocator<U>&) {}

    T* allocate(std::size_t count) {
        if (count > ~std::size_t{0} / 2 / sizeof(T)) throw std::bad_array_new_length{};
        const std::size_t bytes = count * sizeof(T);
        void* const memory = ::operator new(bytes, alignment(bytes));
#if defined(MADV_HUGEPAGE)
        if (bytes >= page) madvise(memory, bytes, MADV_HUGEPAGE); // a wish: what it returns changes nothing
#endif
        return static_cast<T*>(memory);
    }
    void deallocate(T* memory, std::size_t count) noexcept { ::operator delete(memory, alignment(count * sizeof(T))); }

    template <class U>
    void construct(U* place) {
        ::new (static_cast<void*>(place)) U;
    }
    template <class U, class... Values>
    void construct(U* place, Values&&... values) {
        ::new (static_cast<void*>(place)) U(std::forward<Values>(values)...);
    }

    friend bool operator==(const large_allocator&, const large_allocator&) { return true; }

  private:
    static std::align_val_t alignment(std::size_t bytes) {
        return std::align_val_t{bytes >= page ? page : std::size_t{64}};
    }
};

template <class T>
using large_array = std::vector<T, large_allocator<T>>;

} // namespace insonify::inline INSONIFY_ABI
#endif
