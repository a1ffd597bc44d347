#include "devices/errors.h"

#include <fmt/format.h>

#include <system_error>

#include "planner/number_text.h"

namespace palpate {

std::string reason(int error) { return std::generic_category().message(error); }

UnexpectedContact::UnexpectedContact(const Point& where, const std::string& during, std::size_t moves)
    : DeviceError(
          fmt::format("touched something at {} during {}, where space should be free: the part moved, the probe triggered falsely, or what "
                      "was taken to be free is not",
                      point_text(where), during)),
      where_(where),
      moves_(moves) {}

}  // namespace palpate
