#ifndef INSONIFY_CHANNELS_ARRIVING_WAVES_HPP
#define INSONIFY_CHANNELS_ARRIVING_WAVES_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/acoustic_model.hpp>
#include <insonify/channels/element_fans.hpp>
#include <insonify/channels/element_field.hpp>
#include <insonify/channels/pair_sums.hpp>
#include <insonify/channels/reflectors.hpp>
#include <insonify/core/math.hpp>
#include <insonify/core/view.hpp>
#include <insonify/execution/simd.hpp>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace insonify::inline INSONIFY_ABI::detail {

/// The face of the elements of an array, and the frequencies at which waves are computed.
struct radiating_face {
    float frequency = 1e6F; ///< of the carrier, hertz
    float node_step = 1e5F; ///< see `spectral_value`, hertz
    float width = 0;        ///< metres
    float height = 0;       ///< metres
    float speed = 1540;     ///< of sound in front of it, m/s
};

/// What arrives from every element at a reflector, times the root of what the reflector returns.
template <class Model>
class arriving_waves {
  public:
    arriving_waves(view<const ray> places, const element_fans& fans, const elevation_field& field,
                   view<const medium> media, const Model& model, const radiating_face& face)
        : places_{places}, fans_{fans}, field_{field}, media_{media}, model_{model}, face_{face} {
        // sqrt(k w / 2 pi h) sinc(k w sin t / 2): twice this, times a scattering length, is an echo.
        for (int entry = 0; entry <= sines + 1; ++entry)
            for (int node = 0; node < spectral_value::nodes; ++node) {
                const float frequency = face.frequency + spectral_value::steps(node) * face.node_step;
                const float half = pi * frequency * face.width / face.speed * static_cast<float>(entry) / sines;
                radiated_[entry * spectral_value::nodes + node] =
                    std::sqrt(frequency * face.width / (face.speed * face.height)) *
                    (half < 1e-3F ? 1.0F : std::sin(half) / half);
            }
        for (const ray& one : places) heights_.push_back(one.origin.y);
        heights_.resize(places.size() + max_simd_width, 0.0F);
    }

    /// From as many elements as `max_simd_width`, or those that are left.
    /// @param zone_slope  attenuation there and back that is applied later: change with frequency, Np/Hz
    /// @param first       the first of the elements
    /// @param place       of the reflector in `to`
    template <int Nodes>
    void find(const reflector& one, float zone_slope, std::size_t first, wave_table<Nodes>& to,
              std::size_t place) const {
        constexpr int width = max_simd_width;
        using floats = lanes<width>;
        const auto at = fans_.template find<width>(first, one.place);
        several<width> arrived;
        store(at.line, arrived.line);
        store(at.distance, arrived.distance);
        store(at.cosine, arrived.cosine);
        const std::size_t count = std::min<std::size_t>(width, places_.size() - first);
        for (std::size_t k = 0; k < count; ++k) arrive(one, first + k, k, arrived);

        const floats distance = at.distance, range = load<width>(arrived.range);
        // Near the element the distance to most of its face is longer: there 1 / r would grow without bound.
        const floats amplitude = load<width>(arrived.factor) * at.cosine * distance *
                                 power_of_two<width>(load<width>(arrived.lost) * floats(-1.4426950F)) /
                                 sqrt(max(load<width>(arrived.spread) * range, floats(1e-10F)) *
                                      (distance * distance + floats(face_.width * face_.width)));
        const floats y = floats(one.y) - load<width>(heights_.data() + first), square = y * y;
        const floats in_space = sqrt(distance * distance + square); // the distance
        const floats time = load<width>(arrived.time) * in_space * at.per_metre;
        const floats frequency(-face_.frequency), eighth(0.125F); // of a turn: sqrt(j)
        const floats whole = floats_of<width>(floor_bits<width>(frequency * time + eighth + floats(0.5F)));
        const turned_lanes<width> carrier{multiply_add(frequency, time, eighth - whole)};
        const floats position = field_.position<width>(one.tall ? range : sqrt(range * range + square));
        store(time, arrived.time);
        // Of a point out of the slice: 1 / r, cos and sin are those in space.
        const floats nearer = one.tall ? floats(1.0F) : distance / in_space;
        store(amplitude * nearer * nearer, arrived.factor);
        store(carrier.x, arrived.carrier_x);
        store(carrier.y, arrived.carrier_y);
        store(position, arrived.position);
        store(abs(at.sine) * nearer * floats(static_cast<float>(sines)), arrived.sine);
        for (std::size_t k = 0; k < count; ++k) {
            const std::size_t column = first + k;
            if (!(arrived.factor[k] > 0)) {
                to.clear(column, place);
                continue;
            }
            const spectral_value across = one.tall ? field_.surface(arrived.position[k])
                                                   : field_.point(arrived.position[k], one.y - heights_[column]);
            const spectral_value wave =
                spectral_value::everywhere({arrived.carrier_x[k], arrived.carrier_y[k]}) * (across * one.root);
            const float lost = arrived.lost_slope[k] - 0.5F * zone_slope;
            lanes<spectral_value::nodes> face =
                radiated(arrived.sine[k]) * lanes<spectral_value::nodes>(arrived.factor[k]);
            if (lost != 0)
                face = face * power_of_two<spectral_value::nodes>(
                                  lanes<spectral_value::nodes>(-1.4426950F * lost * face_.node_step) *
                                  spectral_value::steps());
            (face * wave).template store_middle<Nodes>(to.set(column, place, arrived.time[k], arrived.facing[k]));
        }
    }

  private:
    static constexpr int sines = 256; // of a table, over which sinc is linear within 2e-5

    template <int N>
    struct several {
        float line[N], distance[N], cosine[N], sine[N];
        float time[N] = {}, factor[N] = {}, facing[N] = {};
        float lost[N] = {}, spread[N] = {}, range[N] = {}, lost_slope[N] = {};
        float carrier_x[N], carrier_y[N], position[N];
    };

    lanes<spectral_value::nodes> radiated(float sine) const {
        const auto entry = std::min(static_cast<std::size_t>(sine), std::size_t{sines});
        const float part = sine - static_cast<float>(entry);
        const float* const from = radiated_ + entry * spectral_value::nodes;
        return lanes<spectral_value::nodes>(1 - part) * load<spectral_value::nodes>(from) +
               lanes<spectral_value::nodes>(part) * load<spectral_value::nodes>(from + spectral_value::nodes);
    }

    // What the layers make of the wave of one element; its factor stays 0 where nothing arrives.
    template <int N>
    INSONIFY_INLINE void arrive(const reflector& one, std::size_t element, std::size_t k, several<N>& at) const {
        if (!(at.line[k] >= 0) || !(at.cosine[k] > 0)) return;
        const arrived_wave wave =
            one.surface ? fans_.at_surface(element, at.line[k], at.distance[k], one.object_before, one.object_after)
                        : fans_.at_point(element, at.line[k], at.distance[k]);
        at.time[k] = wave.time;
        at.lost[k] = wave.lost;
        at.spread[k] = wave.spread;
        at.range[k] = wave.range;
        at.lost_slope[k] = wave.lost_slope;
        at.facing[k] = 0.5F;
        at.factor[k] = wave.passed;
        if (!one.surface || one.normal == vec2{0, 0} || !(wave.passed > 0)) return;
        const ray& face = places_[element];
        const vec2 to = (vec2{face.origin.x, face.origin.z} - one.place) / at.distance[k];
        const float cosine = dot(to, one.normal);
        if (!(cosine > 0)) {
            at.factor[k] = 0;
            return;
        }
        at.facing[k] = 0.5F * cosine;
        // Between two elements the wave is reflected at half of the angle between them, seen from the surface; the
        // nearest element stands for the other one. Roughness sees the angle to the surface itself.
        const incidence between{media_[one.before], media_[one.after], clamp(dot(to, one.nearest), 0.2F, 1),
                                face_.frequency, one.roughness};
        incidence met = between;
        met.cosine = min(cosine, 1);
        // Where the surface turns away, its share fades: an edge of the lit part would return a wave of its own.
        constexpr float fading = 0.25F; // cosine, beyond 75 degrees
        const float lit = min(cosine / fading, 1);
        at.factor[k] *= lit * lit * (3 - 2 * lit) * // the root of what both ways make of it
                        std::sqrt(std::fabs(model_.at_interface(between).reflected) * model_.roughness.coherent(met));
    }

    view<const ray> places_;
    const element_fans& fans_;
    const elevation_field& field_;
    view<const medium> media_;
    const Model& model_;
    radiating_face face_;
    std::vector<float> heights_{};                             // y of the elements, metres
    float radiated_[(sines + 2) * spectral_value::nodes] = {}; // at sines, at each node
};

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
