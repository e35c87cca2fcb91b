# names: the ways that make commands
# Cells end midway between the values: of the length, and of the logarithm of the rate.
low(x) = x == 1 ? 0 : x == 3 ? 2 : x == 5 ? 4 : x == 10 ? 7.5 : x == 15 ? 12.5 : 17
high(x) = x == 1 ? 2 : x == 3 ? 4 : x == 5 ? 7.5 : x == 10 ? 12.5 : x == 15 ? 17 : 21
below(y) = y == 0.5 ? 0.25 : y == 2 ? 1 : y == 5 ? sqrt(10) : sqrt(50)
above(y) = y == 0.5 ? 1 : y == 2 ? sqrt(10) : y == 5 ? sqrt(50) : 10*sqrt(2)
@canvas 1000,810
set multiplot layout 3,2 title 'Aborts over length and rate of bursts, hard' @heading
do for [way = 0:4] {
  @panel
  set title names[way + 1]
  set xlabel 'commands lost in a row'
  set ylabel 'bursts a second'
  set cblabel 'aborted [%]'
  set cbrange [0:100]
  set rmargin 15
  set logscale y
  set autoscale yfix
  plot $data using (of("way [-]", way, "commands lost in a row [-]")):2:(low($3)):(high($3)):(below($2)):(above($2)):4 @cells
}
