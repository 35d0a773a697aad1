#define INSONIFY_IMPLEMENTATION
#include "phantoms.hpp"
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#if __has_include(<stb_image.h>)
#include <stb_image.h>
#else
#include <stb/stb_image.h>
#endif
#include "compare.hpp"
#include <cstdio>
#include <filesystem>
#include <string>

/// Draws the phantoms and compares them with the pictures beside this file, which were looked at when they were accepted.
///
///     insonify_pictures <folder of references>            those that differ go to <name>.png: picture, reference, difference
///     insonify_pictures <folder of references> --accept   what is drawn now becomes the reference
namespace {

using namespace insonify;

image read(const std::string& path) {
    int width = 0, height = 0;
    unsigned char* const grey = stbi_load(path.c_str(), &width, &height, nullptr, 1);
    if (grey == nullptr) return {};
    image seen{{static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)}};
    for (std::size_t i = 0; i < seen.pixels.size(); ++i) seen.pixels[i] = static_cast<float>(grey[i]) / 255;
    stbi_image_free(grey);
    return seen;
}

// What must not pass: a picture moved by one pixel, and one that is a little brighter.
bool notices(const image& reference) {
    image moved = reference, brighter = reference;
    for (std::size_t i = 1; i < moved.pixels.size(); ++i) moved.pixels[i] = reference.pixels[i - 1];
    for (float& p : brighter.pixels) p = p > 0 ? p + 0.012F : p;
    return pictures::compare(reference, reference).enough() && !pictures::compare(reference, moved).enough() &&
           !pictures::compare(reference, brighter).enough();
}

} // namespace

int main(int count, char** arguments) {
    const std::string folder = count > 1 ? arguments[1] : ".";
    const bool accept = count > 2 && std::string{arguments[2]} == "--accept";
    int failed = 0;
    for (const pictures::phantom& one : pictures::all) {
        image seen = one.draw();
        for (float& p : seen.pixels) p = std::round(clamp(p, 0, 1) * 255) / 255; // as a PNG has it
        const std::string reference = folder + "/" + one.name + ".png";
        if (accept) {
            write_png(reference, seen);
            continue;
        }
        const image before = read(reference);
        const pictures::likeness similar = pictures::compare(seen, before);
        const bool good = similar.enough() && notices(before);
        std::printf("%-16s %.4f of the pixels within 2/255, SSIM %.5f%s\n", one.name, similar.pixels,
                    similar.structural, good ? "" : "  FAILED");
        if (good) continue;
        ++failed;
        const std::string shown = std::string{one.name} + ".png";
        write_png(shown, before.size == seen.size ? pictures::side_by_side(seen, before) : seen);
        std::printf("  see %s\n", std::filesystem::absolute(shown).string().c_str());
    }
    return failed == 0 ? 0 : 1;
}
