#ifndef INSONIFY_TRACING_EACH_LINE_HPP
#define INSONIFY_TRACING_EACH_LINE_HPP

#include <insonify/tracing/elevation.hpp>
#include <insonify/tracing/slice_lines.hpp>

namespace insonify::inline INSONIFY_ABI {

/// How the crossings of lines are found: the same ones, but for lines within
/// rounding of a vertex or an edge.
enum class search {
  best,   ///< as `slices_pay` says
  rays,   ///< one ray for each line and slice, through the trees
  slices, ///< the slices are cut once and shared out; rays where the lines are
          ///< no `line_fan`
};

/// What `for_each_line` keeps from frame to frame, so that it allocates once.
struct line_workspace {
  struct block {
    line_crossings found{};
    std::vector<layer> layers{};
    slice_lines::block_segments segments{};
  };
  slice_lines slices{};
  std::vector<block> blocks{};
};

/// Beam `line` of a probe that stands in the world as `at` says.
template <transducer Probe>
INSONIFY_FN ray world_beam(const Probe &probe, const pose &at, float line) {
  const ray local = probe.beam(line);
  return {.origin = at.point(local.origin),
          .direction = at.direction(local.direction)};
}

/// Whether cutting slices is faster than tracing so many rays: a ray costs
/// about as much as cutting 40 faces, and a slice goes through about two faces
/// for each of the sqrt(faces) that lie along it. Always where a tree waits.
inline bool slices_pay(const scene &body, std::size_t lines) {
  float faces = 0;
  for (const object &one : body.objects()) {
    if (!one.tree_follows)
      return true;
    faces += 2 * std::sqrt(static_cast<float>(one.surface.faces.size()));
  }
  return faces <= 40 * static_cast<float>(lines);
}

/// Finds what every line of a probe runs through, down to `reach` metres, in
/// each of its slices: visit(line, plane, frame, layers), the planes of one
/// line in order and by one thread.
/// @throws usage_error  where rays are traced while a tree of the scene waits
template <exec::policy Policy, transducer Probe, class Visit>
void for_each_line(const Policy &policy, search by, const scene &body,
                   const Probe &probe, const pose &at,
                   const elevation_planes &planes, float reach,
                   line_workspace &own, const Visit &visit) {
  constexpr std::size_t block = slice_lines::block;
  const bool sliced =
      by != search::rays &&
      (by == search::slices || slices_pay(body, probe.lines)) && //
      own.slices.take(probe);
  if (sliced) {
    float offsets[elevation_planes::most];
    for (std::uint32_t plane = 0; plane < planes.count(); ++plane)
      offsets[plane] = planes.offset(plane);
    own.slices.cut(policy, body, at, {offsets, planes.count()}, reach);
  } else {
    body.require_trees();
  }
  const std::size_t blocks = (probe.lines + block - 1) / block;
  if (own.blocks.size() < blocks)
    own.blocks.resize(blocks);
  const vec3 elevation = at.direction({0, 1, 0});
  exec::for_each_block(
      policy, probe.lines, block, [&](std::size_t begin, std::size_t end) {
        line_workspace::block &mine = own.blocks[begin / block];
        if (sliced)
          own.slices.start(begin, mine.segments);
        for (std::size_t i = begin; i < end; ++i) {
          ray beam = world_beam(probe, at, static_cast<float>(i));
          const vec3 origin = beam.origin;
          for (std::uint32_t plane = 0; plane < planes.count(); ++plane) {
            beam.origin = origin + planes.offset(plane) * elevation;
            if (sliced)
              own.slices.find(i, plane, beam.origin, mine.segments, mine.found);
            else
              find_crossings(body, beam, reach, mine.found);
            const line_frame frame{beam.origin, beam.direction, elevation};
            stack_layers(body, frame, reach, mine.found, mine.layers);
            visit(static_cast<std::uint32_t>(i), plane, frame,
                  view<const layer>{mine.layers});
          }
        }
      });
}

} // namespace insonify::inline INSONIFY_ABI
#endif
