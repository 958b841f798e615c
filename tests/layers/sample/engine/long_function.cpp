// Read by the test of `functions` alone: the constructor has 61 lines from brace to brace, the last line 121 columns.
constexpr int table[] = {
    0,
    1,
    2,
};
struct Sample {
  Sample();
  int one() const { return 1; }
  int first_, second_;
};

Sample::Sample() : first_{0}, second_(1) {
  first_ += 0;  // }
  first_ += 1;  // }
  first_ += 2;  // }
  first_ += 3;  // }
  first_ += 4;  // }
  first_ += 5;  // }
  first_ += 6;  // }
  first_ += 7;  // }
  first_ += 8;  // }
  first_ += 9;  // }
  first_ += 10;  // }
  first_ += 11;  // }
  first_ += 12;  // }
  first_ += 13;  // }
  first_ += 14;  // }
  first_ += 15;  // }
  first_ += 16;  // }
  first_ += 17;  // }
  first_ += 18;  // }
  first_ += 19;  // }
  first_ += 20;  // }
  first_ += 21;  // }
  first_ += 22;  // }
  first_ += 23;  // }
  first_ += 24;  // }
  first_ += 25;  // }
  first_ += 26;  // }
  first_ += 27;  // }
  first_ += 28;  // }
  first_ += 29;  // }
  first_ += 30;  // }
  first_ += 31;  // }
  first_ += 32;  // }
  first_ += 33;  // }
  first_ += 34;  // }
  first_ += 35;  // }
  first_ += 36;  // }
  first_ += 37;  // }
  first_ += 38;  // }
  first_ += 39;  // }
  first_ += 40;  // }
  first_ += 41;  // }
  first_ += 42;  // }
  first_ += 43;  // }
  first_ += 44;  // }
  first_ += 45;  // }
  first_ += 46;  // }
  first_ += 47;  // }
  first_ += 48;  // }
  first_ += 49;  // }
  first_ += 50;  // }
  first_ += 51;  // }
  first_ += 52;  // }
  first_ += 53;  // }
  first_ += 54;  // }
  first_ += 55;  // }
  first_ += 56;  // }
  first_ += 57;  // }
  first_ += 58;  // }
}
int two() {
  return 2;
}
int three() { return sizeof("{{"); }
// xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx
