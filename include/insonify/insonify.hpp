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
#include <insonify/fwd.hpp>
#include <insonify/geometry/implicit.hpp>
#include <insonify/geometry/needle.hpp>
#include <insonify/image/m_mode.hpp>
#include <insonify/motion.hpp>
#include <insonify/paper.hpp>
#include <insonify/scene/skin.hpp>
#include <insonify/tracing/read/ground_truth.hpp>

#endif
// Outside the guard, so that it is reached also after an earlier include or a precompiled header.
#include <insonify/io.hpp>
#if defined(INSONIFY_IMPLEMENTATION) && defined(INSONIFY_COMPILED) && !defined(INSONIFY_COMPILED_HERE)
#define INSONIFY_COMPILED_HERE
INSONIFY_COMPILED_TEMPLATES()
#endif
