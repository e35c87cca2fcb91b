# names: the ways that make commands; then the label of the x axis and the title
label = names[6]
array tempos[3] = ['canonical', 'brisk', 'hard']
at(tempo, way) = column("tempo [-]") == tempo && column("way [-]") == way ? column(label) : NaN
@canvas 1000,930
set multiplot layout 3,2 title names[7] @heading
do for [tempo = 0:2] {
  @panel
  set title tempos[tempo + 1].': aborted'
  set xlabel label
  set ylabel '[%]'
  set logscale x
  set yrange [-5:105]
  plot for [way = 0:4] $data using (at(tempo, way)):"aborted [%]" @line lc rgb series(way + 1) title tempo == 0 ? names[way + 1] : ''
  @panel
  set title tempos[tempo + 1].': error of the completed'
  set xlabel label
  set ylabel '[mrad]'
  set logscale xy
  plot for [way = 0:4] $data using (at(tempo, way)):"RMS error [mrad]" @line lc rgb series(way + 1) notitle
}
