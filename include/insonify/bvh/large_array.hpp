#ifndef INSONIFY_BVH_LARGE_ARRAY_HPP
#define INSONIFY_BVH_LARGE_ARRAY_HPP

#include <insonify/core/config.hpp>
#include <cstddef>
#include <cstring>
#include <new>
#include <utility>
#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace insonify::inline INSONIFY_ABI {

/// An array that is walked all over: in large pages where the system gives them on request, since a ray through a large
/// tree otherwise waits for the address of nearly every node as well as for the node. New elements are left as they
/// come: write them before they are read, each thread its own.
/// @tparam T  copied as bytes, and nothing to be done at its end
template <class T>
class large_array {
  public:
    large_array() = default;
    explicit large_array(std::size_t count) { resize(count); }
    large_array(const large_array& other) : large_array(other.size_) {
        if (size_ > 0) std::memcpy(static_cast<void*>(first_), other.first_, size_ * sizeof(T));
    }
    large_array(large_array&& other) noexcept { swap(other); }
    large_array& operator=(large_array other) noexcept {
        swap(other);
        return *this;
    }
    ~large_array() { drop(first_, room_); }

    /// Makes room without more elements. @throws std::bad_alloc  and nothing has changed
    void reserve(std::size_t count) {
        if (count <= room_) return;
        T* const larger = allocate(count);
        if (size_ > 0) std::memcpy(static_cast<void*>(larger), first_, size_ * sizeof(T));
        drop(std::exchange(first_, larger), std::exchange(room_, count));
    }
    /// As `reserve`.
    void resize(std::size_t count) {
        reserve(count);
        size_ = count;
    }

    std::size_t size() const { return size_; }
    bool empty() const { return size_ == 0; }
    T* data() { return first_; }
    const T* data() const { return first_; }
    T* begin() { return first_; }
    const T* begin() const { return first_; }
    T* end() { return first_ + size_; }
    const T* end() const { return first_ + size_; }
    T& operator[](std::size_t i) { return first_[i]; }
    const T& operator[](std::size_t i) const { return first_[i]; }

  private:
    static constexpr std::size_t page = std::size_t{2} << 20U; ///< bytes; smaller arrays get ordinary memory

    static std::align_val_t alignment(std::size_t bytes) {
        return std::align_val_t{bytes >= page ? page : std::size_t{64}};
    }
    static T* allocate(std::size_t count) {
        static_assert(__is_trivially_copyable(T) && alignof(T) <= 64);
        if (count > ~std::size_t{0} / 2 / sizeof(T)) throw std::bad_array_new_length{};
        const std::size_t bytes = count * sizeof(T);
        void* const memory = ::operator new(bytes, alignment(bytes));
#if defined(MADV_HUGEPAGE)
        if (bytes >= page) madvise(memory, bytes, MADV_HUGEPAGE); // a wish: what it returns changes nothing
#endif
        return static_cast<T*>(memory);
    }
    static void drop(T* memory, std::size_t count) noexcept {
        if (memory != nullptr) ::operator delete(memory, alignment(count * sizeof(T)));
    }
    void swap(large_array& other) noexcept {
        std::swap(first_, other.first_);
        std::swap(size_, other.size_);
        std::swap(room_, other.room_);
    }

    T* first_ = nullptr;
    std::size_t size_ = 0;
    std::size_t room_ = 0; ///< elements
};

} // namespace insonify::inline INSONIFY_ABI
#endif
