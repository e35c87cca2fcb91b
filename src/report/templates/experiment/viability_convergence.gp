# names: the ways that make commands
at(moves, way) = column("source moves [-]") == moves && column("way [-]") == way ? column("t [s]") : NaN
@canvas 1000,370
set multiplot layout 1,2 title 'To the source from 0.1 rad behind it, joint 1' @heading
do for [moves = 0:1] {
  @panel
  set title '0.1 rad behind a source that '.(moves ? 'moves' : 'stands')
  set xlabel 't [s]'
  set ylabel '|error| [rad]'
  set logscale y
  set xrange [0:3]
  set yrange [1e-7:1]
  plot for [way = 0:|names| - 1] $data using (at(moves, way)):(abs(column("error [rad]"))) @line lc rgb series(way + 1) \
    title moves ? '' : names[way + 1]
}
