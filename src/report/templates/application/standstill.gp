# names: the case on the stiff and the one on the compliant arm
stats $data using "along [mm]" name 'along' nooutput
stats $data using "across [mm]" name 'across' nooutput
stats $data using "estimated [N]" name 'felt' nooutput
stats $data using "push [N]" name 'push' nooutput
low(a, b) = 1.1*(a < b ? (a < 0 ? a : 0) : (b < 0 ? b : 0))
high(a, b) = 1.1*(a > b ? a : b)
@canvas 900,600
set multiplot layout 2,2
do for [i = 0:1] {
  @panel
  set title names[i + 1]
  set xlabel 't [s]'
  set ylabel 'deflection [mm]'
  set yrange [low(along_min, across_min):high(along_max, across_max)]
  plot $data using (of("case", i, "t [s]")):"along [mm]" @line lc rgb (i == 0 ? LF : RA) title 'along the push', \
    '' using (of("case", i, "t [s]")):"across [mm]" @line lc rgb series(4) title 'across', \
    '' using (of("case", i, "t [s]")):"push / stiffness [mm]" @dashed lc rgb LIMIT title 'F(t) / K'
}
do for [i = 0:1] {
  @panel
  set xlabel 't [s]'
  set ylabel 'force [N]'
  set yrange [low(felt_min, push_min):high(felt_max, push_max)]
  plot $data using (of("case", i, "t [s]")):"estimated [N]" @line lc rgb series(5) title 'as the robot estimates it', \
    '' using (of("case", i, "t [s]")):"push [N]" @dashed lc rgb REFERENCE title 'of the push'
}
