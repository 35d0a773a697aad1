#ifndef INSONIFY_COMPILED_HPP
#define INSONIFY_COMPILED_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/paper/law2011.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/scanner.hpp>

/// INSONIFY_COMPILED, defined in every file of a program, compiles the library once: these templates, with the probes,
/// models and policies of the library, are compiled in the file that defines INSONIFY_IMPLEMENTATION, and only declared
/// elsewhere. They take a type-erased policy, and probes as data, so that few instantiations serve all. Templates with
/// a user's types are compiled where they are called, as without the macro.
///
/// Of these functions none is `inline`, nor defined in its class: then compilers do not instantiate them where they are
/// declared `extern template`.
// NOLINTBEGIN(bugprone-macro-parentheses): arguments are types and the word `extern`, which parentheses would break
#define INSONIFY_COMPILED_TEMPLATES(prefix)                                                                            \
    namespace insonify::inline INSONIFY_ABI {                                                                          \
    prefix template void scene::rebuild(const detail::any_policy<false>&);                                             \
    prefix template void scene::follow(const detail::any_policy<false>&);                                              \
    prefix template scene_view detail::scene_views::for_slices(const detail::any_policy<false>&,                       \
                                                               const detail::scene_parts&);                            \
    prefix template scene_view detail::scene_views::for_rays(const detail::any_policy<false>&,                         \
                                                             const detail::scene_parts&);                              \
    prefix template void detail::layer_search::find(const detail::any_policy<false>&, const scene&, const pose&,       \
                                                    const acquisition&, float, bool);                                  \
    INSONIFY_COMPILED_TRACER(prefix, vec2, physical<>, straight_lines)                                                 \
    INSONIFY_COMPILED_TRACER(prefix, vec2, physical<>, paths)                                                          \
    INSONIFY_COMPILED_TRACER(prefix, float, law2011, straight_lines)                                                   \
    INSONIFY_COMPILED_SCANNER(prefix, linear_array)                                                                    \
    INSONIFY_COMPILED_SCANNER(prefix, convex_array)                                                                    \
    INSONIFY_COMPILED_SCANNER(prefix, phased_array)                                                                    \
    INSONIFY_COMPILED_SCANNER(prefix, radial_array)                                                                    \
    INSONIFY_COMPILED_STAGES(prefix, exec::sequenced_policy)                                                           \
    INSONIFY_COMPILED_STAGES(prefix, exec::unsequenced_policy)                                                         \
    INSONIFY_COMPILED_STAGES(prefix, exec::parallel_policy)                                                            \
    INSONIFY_COMPILED_STAGES(prefix, exec::parallel_unsequenced_policy)                                                \
    }

#define INSONIFY_COMPILED_TRACER(prefix, sample, model, how)                                                           \
    prefix template line_grid<sample> line_tracer<model, how>::trace_lines(                                            \
        const detail::any_policy<false>&, const scene&, const pose&, const model&, const acquisition&, const how&,     \
        line_grid<sample>);                                                                                            \
    prefix template line_grid<sample> line_tracer<model, how>::trace_lines(                                            \
        const detail::any_policy<true>&, const scene&, const pose&, const model&, const acquisition&, const how&,      \
        line_grid<sample>);

#define INSONIFY_COMPILED_SCANNER(prefix, probe)                                                                       \
    prefix template const image& scanner<probe>::scan_by(const detail::any_policy<false>&, const scene&, const pose&); \
    prefix template const image& scanner<probe>::scan_by(const detail::any_policy<true>&, const scene&, const pose&);  \
    prefix template const image& scanner<probe>::show_by(const detail::any_policy<false>&, std::uint32_t);             \
    prefix template const image& scanner<probe>::show_by(const detail::any_policy<true>&, std::uint32_t);              \
    prefix template scan_map detail::map_pixels(const detail::any_policy<false>&, const probe&, const acquisition&,    \
                                                const scan_convert_settings&, scan_map);                               \
    prefix template scan_map detail::map_pixels(const detail::any_policy<false>&, const refined<probe>&,               \
                                                const acquisition&, const scan_convert_settings&, scan_map);

#define INSONIFY_COMPILED_STAGES(prefix, policy)                                                                       \
    prefix template iq_lines convolver::along(const policy&, iq_lines, const pulse_envelope&, std::uint32_t);          \
    prefix template iq_lines convolver::across(const policy&, iq_lines);                                               \
    prefix template iq_lines add_electronic_noise(const policy&, iq_lines, const electronic_noise_settings&);          \
    prefix template scan_lines envelope(const policy&, const iq_lines&, scan_lines);                                   \
    prefix template scan_lines tgc(const policy&, scan_lines, float, const tgc_settings&);                             \
    prefix template scan_lines log_compress(const policy&, scan_lines, const log_compress_settings&);                  \
    prefix template scan_lines map_grey(const policy&, scan_lines, const grey_map&);                                   \
    prefix template image scan_convert(const policy&, const scan_lines&, const scan_map&, image);
// NOLINTEND(bugprone-macro-parentheses)

#if defined(INSONIFY_COMPILED)
INSONIFY_COMPILED_TEMPLATES(extern)
#endif

#include <insonify/core/restore_macros.hpp>

#endif
