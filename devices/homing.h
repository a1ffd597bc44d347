// How a machine's position comes to be trusted.
#pragma once

namespace palpate {

enum class Homing {
    require,  // a locked machine is refused: home it by hand
    run,      // a machine that is locked, or says that it is not homed, is homed
    skip,     // no switches: a locked machine is unlocked, and its position taken for right
};

}  // namespace palpate
