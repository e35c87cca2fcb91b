@canvas 900,440
set multiplot layout 2,1
do for [y = 3:4] {
  @panel
  set xlabel 't [s]'
  set ylabel y == 3 ? 'torque [% of its limit]' : 'rate [% of its limit]'
  plot $data using (of("stiff", 1, "t [s]")):y @line lc rgb LF title 'stiff', \
    '' using (of("stiff", 0, "t [s]")):y @line lc rgb RA title 'compliant'
}
