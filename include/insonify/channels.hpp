#ifndef INSONIFY_CHANNELS_HPP
#define INSONIFY_CHANNELS_HPP

/// Channel data: what each element of an array receives, and pictures made from that.
#include <insonify/channels/beamform.hpp>
#include <insonify/channels/tissue_maps.hpp>
#include <insonify/channels/trace_channels.hpp>

#endif
