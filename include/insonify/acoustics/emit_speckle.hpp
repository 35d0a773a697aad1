#ifndef INSONIFY_ACOUSTICS_EMIT_SPECKLE_HPP
#define INSONIFY_ACOUSTICS_EMIT_SPECKLE_HPP

#include <insonify/core/save_macros.hpp>

#include <insonify/acoustics/echo_line.hpp>
#include <insonify/acoustics/echo_path.hpp>
#include <insonify/acoustics/follow_sound.hpp>
#include <insonify/acoustics/scatterers/scattering.hpp>
#include <insonify/core/units.hpp>

namespace insonify::inline INSONIFY_ABI::detail {

/// Emits the speckle of one layer, as `physical` documents it.
/// @param path  at the beginning of the layer
template <class Model, class Echoes>
INSONIFY_FN void emit_speckle(const Model& model, const traced_line& line, const layer& here, const echo_path& path,
                              const Echoes& echoes) {
    const medium& m = line.media[here.medium];
    const float begin = path.shown + path.gains.min_deeper();
    if (!(m.backscatter > 0) || begin >= echoes.depth()) return;
    const float displayed = displayed_stretch(model.timing, m);
    const float attenuation = model.attenuation(m, line.frequency); // dB/m
    const float sigma = sigma_of(line);
    float slot = scatterer_spacing(sigma / displayed); // shorter in slow media
    if (m.flowing) slot = min(slot, scatterer_spacing_in_flow(line.frequency));
    // The pulse sums the power of the slots that it covers: sqrt(pi) sigma over the displayed length of a slot.
    const float pulse_gain = std::sqrt(std::sqrt(pi) * sigma / (slot * displayed));
    float level = m.backscatter * amplitude_of_decibels(model.texture_db) / pulse_gain;
    const float background_loss = model.attenuation(line.media[0], line.frequency);
    // Amplitude there and back at displayed depth `shown`, no less than the floor.
    const auto arriving = [&](float loss_db, float shown, float gain) {
        const float direct =
            line.gains.amplitude(path.passed * amplitude_of_decibels(-pulse_loss(model, line, loss_db)), gain);
        if (model.shadow_floor_db == -FLT_MAX) return direct;
        return max(direct, amplitude_of_decibels(model.shadow_floor_db - shown * background_loss));
    };
    const pose place = line.places.empty() ? pose{} : line.places[here.place];
    const float end = min(here.end, here.begin + (echoes.depth() - begin) / displayed + slot);
    material_line within = in_object(line.frame, place, here.object, m.scatterer_density);
    within.height = line.aperture.height;
    within.plane = line.plane;
    within.aperture = &line.aperture;
    within.displayed = {path.shown - here.begin * displayed, displayed};
    within.tilt = line.frame.tilt;
    within.surfaces = {here.begin, here.end};
    within.flowing = m.flowing;
    within.frame_number = m.flowing ? line.frame_number : 0;
    within.displacement = line.displacement(here.place);
    within.steering = place.local_direction(line.frame.steering);
    if (!m.structure.empty() && here.place < line.structures.size() && line.structures[here.place].of == m.structure) {
        within.fnumber = line.aperture.fnumber(path.shown + 0.5F * (here.end - here.begin) * displayed);
        within.structure = &line.structures[here.place];
        within.own_surfaces = here.own_surfaces;
        level /= within.structure->rms(within.fnumber);
    }
    scatter_along_fibres(model.scattering, within, here.begin, end, slot, [&](const scatterer_run& run) {
        const auto length = static_cast<float>(run.count) * run.step;
        const aperture_gain first = path.gains.at(run.first), last = path.gains.at(run.first + length);
        const auto shown_at = [&](float distance, const aperture_gain& gain) {
            return path.shown + (distance - here.begin) * displayed + gain.deeper;
        };
        const auto level_at = [&](float distance, const aperture_gain& gain) {
            const float arrived =
                arriving(path.lost_at(distance - here.begin, attenuation), shown_at(distance, gain), gain.speckle);
            return min(level * arrived, 1e20F); // keeps sums finite
        };
        const float longer = (last.deeper - first.deeper) / static_cast<float>(run.count > 0 ? run.count : 1);
        echoes.scatterers({.depth = shown_at(run.first, first),
                           .step = max(run.step * displayed + longer, 0),
                           .count = run.count,
                           .real = run.real,
                           .imaginary = run.imaginary,
                           .first_level = level_at(run.first, first),
                           .last_level = level_at(run.first + length, last),
                           .slope = run.slope * displayed});
    });
}

} // namespace insonify::inline INSONIFY_ABI::detail

#include <insonify/core/restore_macros.hpp>

#endif
