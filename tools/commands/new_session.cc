#include "tools/commands/new_session.h"

#include <utility>

#include "config/reader.h"
#include "tools/session_files.h"
#include "tools/session_plan.h"

namespace palpate {

NewSession new_session(const std::filesystem::path& file, const std::vector<std::string>& overrides, const std::filesystem::path& folder,
                       const PictureChoice& picture) {
    SessionConfig config = with_its_files(read_config(file, overrides));
    std::vector<std::filesystem::path> inputs = inputs_of(config, file);
    NewSession session{std::move(config), std::move(inputs), folder, picture};
    if (const std::filesystem::path earlier = session.config.earlier.file; !earlier.empty()) keep_earlier(session, read_file(earlier));
    return session;
}

void keep_earlier(NewSession& session, std::string touches) {
    session.config.earlier.file = std::filesystem::absolute(session.folder / kEarlierFile);
    session.earlier = std::move(touches);
}

}  // namespace palpate
