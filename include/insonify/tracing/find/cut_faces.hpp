#ifndef INSONIFY_TRACING_FIND_CUT_FACES_HPP
#define INSONIFY_TRACING_FIND_CUT_FACES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/bvh/leaf_triangles.hpp>
#include <insonify/tracing/find/slice_frame.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// One corner of each of N triangles, in the coordinates of a slice frame.
template <int N>
struct slice_corner {
    lanes<N> height{}, across{}, along{};
};

/// Lanes of `a` where the mask is set, of `b` elsewhere.
template <int N>
INSONIFY_INLINE slice_corner<N> select_corner(const lane_mask<N>& mask, const slice_corner<N>& a,
                                              const slice_corner<N>& b) {
    return {select(mask, a.height, b.height), select(mask, a.across, b.across), select(mask, a.along, b.along)};
}

/// The points of the edges from `below` to `above` at a height.
///
/// Edges are always interpolated upwards, so that faces that share an edge compute exactly the same point.
template <int N>
INSONIFY_INLINE slice_corner<N> cut_edges(const slice_corner<N>& below, const slice_corner<N>& above, float height) {
    const lanes<N> zero(0.0F), one(1.0F), rise = above.height - below.height;
    const lanes<N> share = (lanes<N>(height) - below.height) / select(zero < rise, rise, one);
    const lanes<N> within = min(max(share, zero), one);
    return {lanes<N>(height), multiply_add(within, above.across - below.across, below.across),
            multiply_add(within, above.along - below.along, below.along)};
}

/// Intersects the triangles of a leaf with the slices that separate their corners: emit(slice number, a bit for each
/// triangle that the slice cuts, from, to).
template <class Range, int Width, class Emit>
INSONIFY_INLINE void cut_faces(const slice_frame& frame, const leaf<Range, Width>& triangles, const Emit& emit) {
    using floats = lanes<Width>;
    slice_corner<Width> corner[3];
    const auto axis = [&](int c, int k) { return load<Width>(triangles.corner[c][k]); };
    bool placed = false;
    for (std::uint32_t slice = 0; slice < frame.count; ++slice) {
        for (int c = 0; c < 3; ++c) corner[c].height = frame.height_of(slice, axis(c, 0), axis(c, 1), axis(c, 2));
        const floats here(frame.height[slice]);
        const auto a = here < corner[0].height, b = here < corner[1].height, c = here < corner[2].height;
        std::uint32_t mixed = ((bits_of(a) ^ bits_of(b)) | (bits_of(a) ^ bits_of(c))) & triangles.usable();
        if (mixed == 0) continue;
        if (!placed) {
            for (int k = 0; k < 3; ++k) {
                corner[k].across = frame.across_of(axis(k, 0), axis(k, 1), axis(k, 2));
                corner[k].along = frame.along_of(axis(k, 0), axis(k, 1), axis(k, 2));
            }
            placed = true;
        }
        // The corner that is alone on its side, and the two that follow it.
        const auto first = (b && c) || !(b || c), second = (a && c) || !(a || c);
        const slice_corner<Width> alone =
            select_corner<Width>(first, corner[0], select_corner<Width>(second, corner[1], corner[2]));
        const slice_corner<Width> next =
            select_corner<Width>(first, corner[1], select_corner<Width>(second, corner[2], corner[0]));
        const slice_corner<Width> last =
            select_corner<Width>(first, corner[2], select_corner<Width>(second, corner[0], corner[1]));
        const auto up = here < alone.height;
        const slice_corner<Width> from = cut_edges(select_corner<Width>(up, next, alone),
                                                   select_corner<Width>(up, alone, next), frame.height[slice]);
        const slice_corner<Width> to = cut_edges(select_corner<Width>(up, last, alone),
                                                 select_corner<Width>(up, alone, last), frame.height[slice]);
        mixed &=
            bits_of(floats(0.0F) <= floats_of<Width>(not_finite<Width>(from.across) | not_finite<Width>(from.along) |
                                                     not_finite<Width>(to.across) | not_finite<Width>(to.along)));
        if (mixed != 0) emit(slice, mixed, from, to);
    }
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
