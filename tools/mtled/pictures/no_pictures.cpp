// Built in place of drawn_pictures.cpp where there is nothing to draw with (PALPATE_APP=OFF).
#include "mtled/report/pictures.h"

namespace palpate::tools {

std::unique_ptr<Pictures> openPictures() { return nullptr; }

std::string withoutPictures() { return "left out: this mtled was built without pictures (PALPATE_APP=OFF)"; }

}  // namespace palpate::tools
