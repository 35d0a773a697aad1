#include <insonify/core/config.hpp>
abi_is INSONIFY_ABI
