# names: the cases D, C and C0
@canvas 900,660
set multiplot layout 3,1
do for [axis in 'x y z'] {
  @panel
  set xlabel 't [s]'
  set ylabel axis.' [mm]'
  plot for [i = 1:3] $data using (of("case", i, "t [s]")):(column(axis.' [mm]')) @line lc rgb word(RA.' '.RS.' '.LF, i) title names[i], \
    $data using (of("case", 3, "t [s]")):(column(axis.'_d [mm]')) @dashed lc rgb LIMIT title 'reference'
}
