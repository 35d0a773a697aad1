#ifndef INSONIFY_TRACING_EACH_LINE_HPP
#define INSONIFY_TRACING_EACH_LINE_HPP

#include <insonify/tracing/elevation.hpp>
#include <insonify/tracing/slice_lines.hpp>

namespace insonify::inline INSONIFY_ABI {

/// How the crossings of lines are found: the same ones, but for lines within rounding of a vertex or an edge.
enum class search {
    best,   ///< for each object whichever is faster, as `slice_lines::choose` says
    rays,   ///< one ray for each line and slice, through the trees
    slices, ///< the slices are cut once and shared out; rays where the lines are no `line_fan`
};

/// What `for_each_line` keeps from frame to frame, so that it allocates once.
struct line_workspace {
    /// What one thread works in.
    struct block {
        line_crossings found;                   ///< of the line at work
        std::vector<layer> layers;              ///< of the line at work
        slice_lines::block_crossings crossings; ///< of the lines of the block
    };
    slice_lines slices;        ///< cut of the scene
    std::vector<block> blocks; ///< one for each block of lines
};

/// Lines that one thread takes at a time.
inline constexpr std::size_t lines_per_block = slice_lines::block;
/// How many blocks that makes.
constexpr std::size_t line_blocks(std::size_t lines) { return (lines + lines_per_block - 1) / lines_per_block; }

/// Beam `line` of a probe that stands in the world as `at` says.
template <transducer Probe>
INSONIFY_FN ray world_beam(const Probe& probe, const pose& at, float line) {
    const ray local = probe.beam(line);
    return {.origin = at.point(local.origin), .direction = at.direction(local.direction)};
}

/// Finds what every line of a probe runs through, down to `reach` metres, in each of its slices: visit(line, plane,
/// frame, layers), the planes of one line in order and by one thread.
/// @param nanoseconds  about what `visit` takes; 1e6F where nothing is known of it
/// @throws usage_error  where rays are traced while a tree of the scene waits
template <exec::policy Policy, transducer Probe, class Visit>
void for_each_line(const Policy& policy, search by, const scene& body, const Probe& probe, const pose& at,
                   const elevation_planes& planes, float reach, angles wanted, line_workspace& own, float nanoseconds,
                   const Visit& visit) {
    const bool sliced =
        by != search::rays && own.slices.take(probe) && own.slices.choose(body, at, by == search::slices);
    if (sliced) {
        float offsets[elevation_planes::most];
        for (std::uint32_t plane = 0; plane < planes.count(); ++plane) offsets[plane] = planes.offset(plane);
        own.slices.cut(policy, body, at, {offsets, planes.count()}, reach);
    } else {
        body.require_trees();
    }
    if (own.blocks.size() < line_blocks(probe.lines)) own.blocks.resize(line_blocks(probe.lines));
    const vec3 elevation = at.direction({0, 1, 0});
    const std::size_t asked = sliced ? own.slices.left_to_rays().size() : body.objects().size();
    const float ray_time = asked == 0 ? 0.0F : 300 + 20 * static_cast<float>(asked);
    const float search_time = ray_time + (sliced ? own.slices.search_time() : 0.0F);
    const float line_time = (nanoseconds + search_time) * static_cast<float>(planes.count());
    exec::for_each_block(policy, probe.lines, lines_per_block, line_time, [&](std::size_t begin, std::size_t end) {
        line_workspace::block& mine = own.blocks[begin / lines_per_block];
        if (sliced) own.slices.start(begin, mine.crossings);
        for (std::size_t i = begin; i < end; ++i) {
            ray beam = world_beam(probe, at, static_cast<float>(i));
            const vec3 origin = beam.origin;
            for (std::uint32_t plane = 0; plane < planes.count(); ++plane) {
                beam.origin = origin + planes.offset(plane) * elevation;
                if (sliced) {
                    own.slices.find(i, plane, beam.origin, mine.crossings, mine.found);
                    for (const std::uint32_t one : own.slices.left_to_rays())
                        add_crossings(body.objects()[one], beam, reach, mine.found);
                    mine.found.sort();
                } else {
                    find_crossings(body, beam, reach, mine.found);
                }
                const line_frame frame{beam.origin, beam.direction, elevation};
                stack_layers(body, frame, reach, mine.found, mine.layers, wanted);
                visit(static_cast<std::uint32_t>(i), plane, frame, view<const layer>{mine.layers});
            }
        }
    });
}

} // namespace insonify::inline INSONIFY_ABI
#endif
