# names: the cases C0 and D0
@canvas 900,300
@panel
set xlabel 't [s]'
set ylabel 'distance [mm]'
plot $data using (of("case", 1, "t [s]")):3 @line lc rgb LF title names[1], \
  '' using (of("case", 2, "t [s]")):3 @line lc rgb RA title names[2]
