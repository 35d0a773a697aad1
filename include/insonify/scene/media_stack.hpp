#ifndef INSONIFY_SCENE_MEDIA_STACK_HPP
#define INSONIFY_SCENE_MEDIA_STACK_HPP

#include <insonify/core/math.hpp>
#include <cstdint>
#include <vector>

namespace insonify::inline INSONIFY_ABI {

/// Which objects contain a point that travels along a line, one bit each, ordered by rank.
///
/// Where objects overlap, the one of lowest rank gives the medium, so that is the lowest bit set.
class media_stack {
  public:
    static constexpr std::uint32_t none = ~0U; ///< rank of the background

    /// In none of so many objects.
    INSONIFY_LAZY void clear(std::size_t objects) {
        words_.resize((objects + 31) / 32); // by a loop: `assign` is a call, for every line
        for (std::size_t i = 0; i < words_.size(); ++i) words_[i] = 0;
    }

    /// The point crosses the surface of this object.
    INSONIFY_LAZY void toggle(std::uint32_t rank) { words_[rank / 32] ^= 1U << (rank % 32); }

    /// Whether the point is in this object.
    INSONIFY_LAZY bool contains(std::uint32_t rank) const { return (words_[rank / 32] >> (rank % 32) & 1U) != 0; }

    /// Rank of the object whose medium counts; `none` outside all.
    INSONIFY_LAZY std::uint32_t top() const {
        for (std::size_t i = 0; i < words_.size(); ++i)
            if (words_[i] != 0) return static_cast<std::uint32_t>(i * 32) + lowest_bit(words_[i]);
        return none;
    }

  private:
    std::vector<std::uint32_t> words_;
};

} // namespace insonify::inline INSONIFY_ABI
#endif
