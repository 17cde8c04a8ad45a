#include <optional>

#include "app/figures/body_painter.h"
#include "app/figures/figure_writer.h"
#include "model/model.h"
#include "mtled/pictures/atlas_map.h"
#include "mtled/report/pictures.h"

namespace palpate::tools {
namespace {

class DrawnPictures : public Pictures {
 public:
  void write(const std::string& png, const Figure& figure) override { writer_.write(png, figure); }
  void write(const std::string& png, const Histogram& histogram) override { writer_.write(png, histogram); }

  void write(const std::string& png, const Picture& picture) override { app::writePng(png, picture); }

  void write(const std::string& png, const BodyPicture& picture, const Model& model, const AlignedVector<Float4>& u,
             const CutPlane* cut) override {
    app::BodyPainter painter(writer_, model, cut ? std::optional(*cut) : std::nullopt);
    painter.write(png, picture, u);
  }

  void write(const std::string& png, const Atlas& atlas, const std::vector<AtlasAxis>& axes) override {
    app::writePng(png, drawAtlasMap(writer_.canvas(), atlas, axes));
  }

 private:
  app::FigureWriter writer_;
};

}  // namespace

std::unique_ptr<Pictures> openPictures() { return std::make_unique<DrawnPictures>(); }

std::string withoutPictures() { return ""; }

}  // namespace palpate::tools
