#include "devices/version.h"

namespace palpate {

std::string_view program_version() { return PALPATE_VERSION; }

}  // namespace palpate
