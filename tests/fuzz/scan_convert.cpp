// Any probe, lines and picture size: either they are refused, or the picture is made of the lines' own values.
#include <insonify/image/scan_convert.hpp>
#include <insonify/paper/picture.hpp>
#include <insonify/probe/convex_array.hpp>
#include <insonify/probe/linear_array.hpp>
#include <insonify/probe/phased_array.hpp>
#include <insonify/probe/radial_array.hpp>
#include "input.hpp"
#include "memory.hpp"
#include <algorithm>

using namespace insonify;

namespace {

/// A small number, mostly; else any.
std::uint32_t count(fuzz::input& in, std::uint32_t largest) {
    const std::uint32_t value = in.byte();
    return value < 0xF0 ? value % (largest + 1) : in.bits();
}

template <transducer Probe>
void check_picture(fuzz::input& in, const Probe& probe) {
    const acquisition scan{.depth = in.number(), .samples = count(in, 9)};
    const scan_convert_settings settings{.size = {count(in, 20), count(in, 20)}, .background = in.number()};
    const std::size_t before = fuzz::start_measuring();
    const scan_map map = make_scan_map(exec::seq, probe, scan, settings);
    const std::size_t pixels = std::size_t{map.size.x} * map.size.y, samples = std::size_t{map.count} * map.samples;
    fuzz::require(map.size.x <= max_picture_side && map.size.y <= max_picture_side, "a map is no larger than pictures");
    fuzz::require(pixels > 0 && map.first.size() == pixels, "a map has its pixels");
    fuzz::require((settings.size.x == 0 || map.size.x == settings.size.x) &&
                      (settings.size.y == 0 || map.size.y == settings.size.y),
                  "a map has the size asked for");
    fuzz::require(fuzz::peak_bytes - before <= 1024 + 12 * pixels, "a map takes 12 bytes a pixel");
    for (std::size_t i = 0; i < pixels; ++i) {
        if (map.first[i] == scan_map::outside) continue;
        const std::size_t below = map.first[i] + (map.samples > 1 ? 1 : 0);
        fuzz::require(below < samples && map.beside(map.first[i]) < samples,
                      "a pixel is made of samples that are there");
        fuzz::require(map.across[i] >= 0 && map.across[i] <= 1 && map.along[i] >= 0 && map.along[i] <= 1,
                      "a pixel lies between its samples");
    }
    if (samples > 4096) return;

    scan_lines lines{map.count, map.samples, map.depth};
    float low = settings.background, high = settings.background;
    for (float& value : lines.values) {
        value = static_cast<float>(in.byte());
        low = std::min(low, value);
        high = std::max(high, value);
    }
    const image picture = scan_convert(exec::seq, lines, map);
    for (const float pixel : picture.pixels)
        fuzz::require(pixel >= low && pixel <= high, "a pixel lies between the values around it");
    for (const float pixel : radial_blur(exec::seq, picture, probe, map, {.lines = 0.5F, .frames = 2}).pixels)
        fuzz::require(is_finite(pixel), "a blurred picture is finite");
    label_lines labels{map.count, map.samples, map.depth};
    std::fill(labels.values.begin(), labels.values.end(), 7U);
    for (const label_id label : scan_convert(exec::seq, labels, map).pixels)
        fuzz::require(label == 7 || label == background_label, "a pixel has the label of a sample");
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const fuzz::allowance small{std::size_t{16} << 10U}; // larger pictures are legal, but take too long here
    fuzz::input in{data, size};
    try {
        const std::uint32_t kind = in.byte();
        const std::uint32_t lines = count(in, 12);
        const float length = in.number(), angle = in.number(), frequency = in.below(4) != 0 ? 5e6F : in.number();
        switch (kind % 4) {
        case 0:
            check_picture(in, linear_array{.lines = lines, .width = length, .frequency = frequency});
            break;
        case 1:
            check_picture(in, convex_array{.lines = lines, .radius = length, .field_of_view = angle});
            break;
        case 2:
            check_picture(in, phased_array{.lines = lines, .width = length, .field_of_view = angle});
            break;
        default:
            check_picture(in, radial_array{.lines = lines, .radius = length, .frequency = frequency});
        }
    } catch (const usage_error&) {
    } catch (const std::bad_alloc&) {
    }
    return 0;
}
