// Compares the includes of the libraries with the plan of their folders, and draws them.
#include <exception>
#include <fstream>
#include <iostream>
#include <string>

#include "source_tree.h"

int main(int argc, char** argv) {
  try {
    const bool draw = argc == 5 && std::string(argv[3]) == "--draw";
    if (argc != 3 && !draw) {
      std::cerr << "layers PLAN ROOT [--draw FILE.svg]: fails on an include that the plan does not allow\n";
      return 2;
    }
    const SourceTree tree = read_tree(argv[1], argv[2]);
    for (const std::string& fault : tree.faults) std::cout << fault << "\n";
    std::cout << tree.folders.size() << " folders, " << tree.faults.size() << " faults\n";
    if (draw && !(std::ofstream(argv[4]) << draw_tree(tree))) {
      std::cerr << "layers: " << argv[4] << ": cannot be written\n";
      return 2;
    }
    return tree.faults.empty() ? 0 : 1;
  } catch (const std::exception& e) {
    std::cerr << "layers: " << e.what() << "\n";
    return 2;
  }
}
