vcpkg_from_github(
    OUT_SOURCE_PATH SOURCE_PATH
    REPO insonify/insonify
    REF "v${VERSION}"
    SHA512 0 # of the release's archive; vcpkg prints it where it differs
    HEAD_REF main
)
set(VCPKG_BUILD_TYPE release) # header-only

vcpkg_cmake_configure(
    SOURCE_PATH "${SOURCE_PATH}"
    OPTIONS
        -DINSONIFY_TESTS=OFF
        -DINSONIFY_EXAMPLES=OFF
        -DINSONIFY_INSTALL=ON
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup()
vcpkg_fixup_pkgconfig()

file(INSTALL "${CMAKE_CURRENT_LIST_DIR}/usage" DESTINATION "${CURRENT_PACKAGES_DIR}/share/${PORT}")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE")
