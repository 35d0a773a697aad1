#include <insonify/image/image.hpp>
#include <doctest/doctest.h>

using namespace insonify;

namespace image_test {

TEST_CASE("image: pixels are stored in rows from the top, addressed by column and row") {
    image picture{{3, 2}};
    CHECK(picture.pixels == std::vector<float>(6, 0.0F));
    picture(2, 1) = 0.5F;
    CHECK(picture.pixels == std::vector<float>{0, 0, 0, 0, 0, 0.5F});
    picture(0, 1) = 1;
    CHECK(picture.pixels[3] == 1);
    CHECK(image{{2, 2}, 0.25F}.pixels == std::vector<float>(4, 0.25F));
    CHECK(image{}.pixels.empty());
}

TEST_CASE("image: images are equal if size and all pixels are") {
    CHECK(image{{3, 2}} == image{{3, 2}});
    CHECK(image{{3, 2}} != image{{2, 3}});
    CHECK(image{{3, 2}} != image{{3, 2}, 1});
}

} // namespace image_test
