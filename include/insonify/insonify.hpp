#ifndef INSONIFY_INSONIFY_HPP
#define INSONIFY_INSONIFY_HPP

/// All of insonify. In exactly one file of a program define INSONIFY_IMPLEMENTATION before including this: the OBJ
/// reader and the PNG writer are compiled there. What is not named here, these include.
#include <insonify/b_mode.hpp>
#include <insonify/channels.hpp>
#include <insonify/compiled.hpp>
#include <insonify/diagnose.hpp>
#include <insonify/doppler.hpp>
#include <insonify/examinations.hpp>
#include <insonify/execution/policy.hpp>
#include <insonify/fwd.hpp>
#include <insonify/geometry/implicit.hpp>
#include <insonify/geometry/needle.hpp>
#include <insonify/image/m_mode.hpp>
#include <insonify/image/scan_convert.hpp>
#include <insonify/motion.hpp>
#include <insonify/paper.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/line_grid.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/presets.hpp>
#include <insonify/probe/radial_array.hpp>
#include <insonify/probe/transducer.hpp>
#include <insonify/scanner.hpp>
#include <insonify/scene/queries.hpp>
#include <insonify/scene/scene.hpp>
#include <insonify/scene/skin.hpp>
#include <insonify/signal/compound.hpp>
#include <insonify/signal/electronic_noise.hpp>
#include <insonify/signal/envelope.hpp>
#include <insonify/signal/gain.hpp>
#include <insonify/signal/kernel/convolve.hpp>
#include <insonify/signal/persistence.hpp>
#include <insonify/signal/pulse.hpp>
#include <insonify/signal/resample_lines.hpp>
#include <insonify/tracing/find/find_layers.hpp>
#include <insonify/tracing/paths.hpp>
#include <insonify/tracing/read/ground_truth.hpp>

#endif
// Outside the guard, so that it is reached also after an earlier include or a precompiled header.
#include <insonify/io.hpp>
#if defined(INSONIFY_IMPLEMENTATION) && defined(INSONIFY_COMPILED) && !defined(INSONIFY_COMPILED_HERE)
#define INSONIFY_COMPILED_HERE
INSONIFY_COMPILED_TEMPLATES()
#endif
