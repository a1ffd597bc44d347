// palpate picture: draws a session again.
#include <ostream>

#include "tools/commands/commands.h"
#include "tools/results.h"
#include "tools/session_files.h"

namespace palpate {

ExitCode run(const PictureCommand& command, Output& output) {
    std::ostream& out = output.results;
    draw_session_picture(command.folder, command.up);
    out << "written to     " << (command.folder / kPictureFile).string() << '\n';
    return ExitCode::done;
}

}  // namespace palpate
