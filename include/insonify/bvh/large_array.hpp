#ifndef INSONIFY_BVH_LARGE_ARRAY_HPP
#define INSONIFY_BVH_LARGE_ARRAY_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/core/config.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <utility>
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

/// An array with random access, backed by huge pages where the system provides them: traversal of a large tree
/// otherwise has a TLB miss at nearly every node. New elements are uninitialised.
/// @tparam T  trivially copyable
template <class T>
class large_array {
  public:
    large_array() = default;
    explicit large_array(std::size_t count) { resize(count); }
    large_array(const large_array& other) : large_array(other.size_) {
        if (size_ > 0) std::memcpy(static_cast<void*>(data()), other.data(), size_ * sizeof(T));
    }
    large_array(large_array&& other) noexcept { swap(other); }
    large_array& operator=(large_array other) noexcept {
        swap(other);
        return *this;
    }
    ~large_array() { ::operator delete(held_.memory); }

    /// @throws std::bad_alloc  and leaves the array unchanged
    void reserve(std::size_t count) {
        if (count <= room_) return;
        const block larger{count};
        if (size_ > 0) std::memcpy(static_cast<void*>(larger.first), data(), size_ * sizeof(T));
        ::operator delete(std::exchange(held_, larger).memory);
        room_ = count;
    }
    /// Throws as `reserve` does.
    void resize(std::size_t count) {
        reserve(count);
        size_ = count;
    }

    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    T* data() { return held_.first; }
    const T* data() const { return held_.first; }
    T* begin() { return data(); }
    const T* begin() const { return data(); }
    T* end() { return data() + size_; }
    const T* end() const { return data() + size_; }
    T& operator[](std::size_t i) { return data()[i]; }
    const T& operator[](std::size_t i) const { return data()[i]; }

  private:
    static constexpr std::size_t page = std::size_t{2} << 20U; ///< bytes; smaller arrays use ordinary pages
    static constexpr std::size_t line = 64;                    ///< a cache line

    /// Memory from `operator new`, and the aligned start of the elements. Aligned here because aligned allocations
    /// rarely reuse freed memory: the system would clear new pages for every tree.
    struct block {
        void* memory = nullptr;
        T* first = nullptr;

        block() = default;
        explicit block(std::size_t count) {
            static_assert(__is_trivially_copyable(T) && alignof(T) <= line);
            if (count > ~std::size_t{0} / 2 / sizeof(T)) throw std::bad_array_new_length{};
            const std::size_t bytes = count * sizeof(T), alignment = bytes >= page ? page : line;
            memory = ::operator new(bytes + alignment);
            const std::size_t past = reinterpret_cast<std::uintptr_t>(memory) % alignment;
            void* const aligned = static_cast<char*>(memory) + (alignment - past);
#if defined(MADV_HUGEPAGE)
            if (bytes >= page) madvise(aligned, bytes, MADV_HUGEPAGE); // a hint: its result does not matter
#endif
            first = static_cast<T*>(aligned);
#if defined(INSONIFY_ADDRESS_SANITIZER) // the padding before and after the elements
            __asan_poison_memory_region(memory, alignment - past);
            __asan_poison_memory_region(first + count, past);
#endif
        }
    };
    void swap(large_array& other) noexcept {
        std::swap(held_, other.held_);
        std::swap(size_, other.size_);
        std::swap(room_, other.room_);
    }

    block held_{};
    std::size_t size_ = 0;
    std::size_t room_ = 0; ///< elements
};

} // namespace insonify::inline INSONIFY_ABI::detail
#undef INSONIFY_ADDRESS_SANITIZER

#include <insonify/core/restore_macros.hpp>

#endif
